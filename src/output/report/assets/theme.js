// Colors of the picture, light and dark.

const THEMES = {
  light: { back: 0xffffffff, ink: "#1c1f24", dark: 0xff241f1c, faint: 0xff6b6660, wall: "#b0b4ba", arrow: "#c2261f", halo: "#ffffff", plain: 0xffe4e0de, kinds: ["#2166ac", "#e66101"], marks: { held: "#0b6b58", load: "#b3006b", part: "#1c1f24", joint: "#8a4b00" } },
  dark: { back: 0xff1c1714, ink: "#e8eaee", dark: 0xffeeeae8, faint: 0xff5a5148, wall: "#6a7079", arrow: "#ff8f7a", halo: "#14171c", plain: 0xff504942, kinds: ["#67a9f0", "#ff9440"], marks: { held: "#5fe0c0", load: "#ff86cf", part: "#e8eaee", joint: "#ffc06b" } },
};

// The color bar as a background.
const rampOf = (colors) => `linear-gradient(to right, ${colors.filter((_, k) => k % 15 === 0).map((color) => `rgb(${color.join(" ")})`).join(", ")})`;

const themeNow = () => {
  const chosen = document.documentElement.dataset.theme;
  const isDark = chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  return THEMES[isDark ? "dark" : "light"];
};

// Changes the theme where the reader chooses one, or the system does.
const listenToTheme = (redraw) => {
  $("theme").addEventListener("change", () => {
    if ($("theme").value) document.documentElement.dataset.theme = $("theme").value;
    else delete document.documentElement.dataset.theme;
    redraw();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
};
