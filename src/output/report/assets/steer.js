// Moving, zooming and turning of pictures with the pointer, the wheel and keys; several pictures move together.

// Largest motion of the pointer in pixels that is a click.
const STILL = 4;

// `moved`: after a motion; `whole`: shows everything; `keys`: further keys; `hover` and `click`: what is under the pointer.
const steer = (canvas, scenes, { moved, whole, keys = {}, hover = () => {}, leave = () => {}, click = () => {} }) => {
  const all = (change) => {
    scenes.forEach(change);
    moved();
  };
  const turn = (dx, dy) => all((scene) => {
    scene.turn[0] -= dx;
    scene.turn[1] = clamp(scene.turn[1] + dy, -1.57, 1.57);
  });
  const isSpace = scenes.some((scene) => scene.isSpace);
  canvas.addEventListener("wheel", (event) => {
    // Only with the focus or a key, so that scrolling the page over the picture still scrolls the page.
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    all((scene) => scene.zoomBy(Math.exp(-0.0015 * event.deltaY), event.offsetX, event.offsetY));
  }, { passive: false });
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    pressed = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!(event.buttons & 1)) return hover(event);
    if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > STILL) pressed = null;
    if (pressed) return undefined;
    if (isSpace && event.shiftKey) turn(0.008 * event.movementX, 0.008 * event.movementY);
    else all((scene) => scene.moveBy(event.movementX, event.movementY));
    return leave();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (pressed) click(event);
    pressed = null;
  });
  canvas.addEventListener("pointerleave", leave);
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = 40, move = (dx, dy) => all((scene) => scene.moveBy(dx, dy)), zoom = (factor) => all((scene) => scene.zoomBy(factor));
    const shifted = { "ArrowLeft": () => move(step, 0), "ArrowRight": () => move(-step, 0), "ArrowUp": () => move(0, step), "ArrowDown": () => move(0, -step) };
    const plain = {
      "+": () => zoom(1.3), "=": () => zoom(1.3), "-": () => zoom(1 / 1.3), "0": whole,
      ...(isSpace ? { a: () => turn(-0.1, 0), d: () => turn(0.1, 0), w: () => turn(0, 0.1), s: () => turn(0, -0.1) } : {}),
      ...keys,
    };
    const action = (event.shiftKey ? shifted[event.key] : null) ?? plain[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
  return { zoom: (factor) => all((scene) => scene.zoomBy(factor)) };
};
