// Curves of the last ten minutes.
const WIDTH = 300, HEIGHT = 72, SPAN = 600;
const SVG = "http://www.w3.org/2000/svg";

function element(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

/// `columns`: values for each of the instants `at`, one curve each.
export function drawGraph(svg, at, columns) {
  const now = at.length ? at[at.length - 1] : 0;
  // A farm that is young has its few minutes over the whole width.
  const span = Math.min(SPAN, Math.max(60, now - (at[0] ?? 0)));
  const most = Math.max(1e-9, ...columns.flat());
  const x = (time) => (WIDTH * (1 - (now - time) / span)).toFixed(1);
  const y = (value) => (HEIGHT - 1 - (HEIGHT - 6) * value / most).toFixed(1);
  const parts = [element("line", { class: "base", x1: 0, x2: WIDTH, y1: HEIGHT - 0.5, y2: HEIGHT - 0.5 })];
  columns.forEach((values, i) => {
    if (values.length < 2) return;
    const points = values.map((value, k) => `${x(at[k])} ${y(value)}`).join("L");
    const second = i > 0 ? " second" : "";
    parts.push(element("path", { class: `area${second}`, d: `M${x(at[0])} ${HEIGHT}L${points}L${WIDTH} ${HEIGHT}Z` }));
    parts.push(element("path", { class: `curve${second}`, d: `M${points}` }));
  });
  svg.replaceChildren(...parts);
}
