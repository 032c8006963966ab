(() => {
"use strict";
// Small things that all parts use.

const $ = (id) => document.getElementById(id);

// An element with properties and children; texts become text, never markup.
const element = (tag, properties = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("data-") || name.startsWith("aria-") || name === "role" || name === "scope" || name === "colspan") made.setAttribute(name, value);
    else made[name] = value;
  }
  made.append(...children);
  return made;
};

// The name of the language of the plots; nothing is loaded from there.
const NAMESPACE = "http://www.w3.org/2000/svg";

const svg = (tag, attributes = {}, ...children) => {
  const made = document.createElementNS(NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
};

// The fewest digits that read back as the same number, as in history.csv; nothing where there is no value.
const exact = (value) => {
  if (value === null || Number.isNaN(value)) return "–";
  return value !== 0 && Math.abs(value) < 1e-4 ? value.toExponential() : String(value);
};

// A number to read: six digits at most, with an exponent where its size asks for one.
const brief = (value, digits = 6) => {
  if (value === null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const rounded = Number(value.toPrecision(digits)), size = Math.abs(rounded);
  const text = size >= 1e7 || size < 1e-4 ? rounded.toExponential().replace("e+", "e") : rounded.toString();
  return text.replaceAll("-", "−");
};

const words = (name) => name.replaceAll("_", " ");
// A value with the unit of a column or field, and that unit in brackets, where the script declares units.
const inUnit = (text, data, kind, name) => data.units?.[kind][name] ? `${text} ${data.units[kind][name]}` : text;
const unitOf = (data, kind, name) => data.units?.[kind][name] ? ` [${data.units[kind][name]}]` : "";

// Draws a page with the next picture of the screen.
const drawSoon = (page) => {
  if (page.isAsked) return;
  page.isAsked = true;
  requestAnimationFrame(() => {
    page.isAsked = false;
    page.draw();
  });
};

// The words for a field, with its unit where that is known.
const titled = ({ name, words: text }, data) => `${text}${unitOf(data, "fields", name)}`;

// Texts of equally spaced numbers with as many digits as tell them apart.
const tickTexts = (values) => {
  const largest = Math.max(...values.map(Math.abs)), step = values.length > 1 ? Math.abs(values[1] - values[0]) : largest;
  const digits = step > 0 ? clamp(Math.ceil(Math.log10(largest / step)) + 2, 3, 14) : 6;
  return values.map((value) => brief(Math.abs(value) < 1e-9 * step ? 0 : value, digits));
};

// Round numbers between two ends.
const ticks = (low, high, count) => {
  const raw = (high - low) / count;
  if (!(raw > 0) || !Number.isFinite(raw)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((step) => step >= raw * 0.999);
  const all = [];
  for (let k = Math.ceil(low / step - 1e-6); k * step <= high + 1e-6 * step; k += 1) all.push(k * step);
  return all;
};

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
