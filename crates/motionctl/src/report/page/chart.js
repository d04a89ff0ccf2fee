// Curves over time as SVG: drawn for the width that there is, from every sample, at any zoom.

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 70, RIGHT = 10, TOP = 8, BOTTOM = 22, LABEL = 12;

function element(parent, tag, attributes = {}, content = "") {
  const made = parent.namespaceURI === SVG || tag === "svg"
    ? document.createElementNS(SVG, tag) : document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (content !== "") made.textContent = content;
  parent.appendChild(made);
  return made;
}

// What is shown of an axis: the same for all charts that share it.
class View {
  constructor(min, max, least) {
    Object.assign(this, { min, max, least, from: min, to: max, cursor: null, charts: [] });
  }
  show(from, to) {
    const span = Math.min(Math.max(to - from, this.least), this.max - this.min);
    this.from = Math.min(Math.max((from + to - span) / 2, this.min), this.max - span);
    this.to = this.from + span;
    this.redraw();
  }
  zoom(factor, centre = (this.from + this.to) / 2) {
    this.show(centre - (centre - this.from) * factor, centre + (this.to - centre) * factor);
  }
  move(share) {
    const by = (this.to - this.from) * share;
    this.show(this.from + by, this.to + by);
  }
  all() { this.show(this.min, this.max); }
  point(at) {
    this.cursor = at;
    for (const chart of this.charts) chart.point();
  }
  redraw() { for (const chart of this.charts) chart.draw(); }
}

function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= least * 0.999) ?? 10 * power;
}

function ticks(from, to, most) {
  const step = niceStep((to - from) / Math.max(1, most));
  const result = [];
  for (let n = Math.ceil(from / step - 1e-9); n * step <= to + step * 1e-9; n++) result.push(n * step);
  return { step, result };
}

function tickText(value, step) {
  if (Math.abs(value) < step * 1e-6) return "0";
  // No label is longer than its place, nine letters.
  const [unit, sign] = Math.abs(value) >= 1e8 ? [1e6, "M"] : Math.abs(value) >= 1e5 ? [1e3, "k"] : [1, ""];
  const digits = Math.max(0, -Math.floor(Math.log10(step / unit) + 1e-9));
  const plain = (value / unit).toFixed(Math.min(digits, 20)) + sign;
  return (plain.length <= 9 ? plain : value.toExponential(2)).replace("-", "\u2212");
}

// The first place at which the values, which ascend, are not below.
function placeOf(values, at) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < at) low = middle + 1; else high = middle;
  }
  return low;
}

function nearest(values, at) {
  const place = placeOf(values, at);
  if (place === 0) return values.length ? 0 : -1;
  if (place === values.length) return place - 1;
  return at - values[place - 1] < values[place] - at ? place - 1 : place;
}

// Gestures of a chart: dragging moves, a wheel with Ctrl, a double click and keys zoom.
function gestures(target, view, toValue, onPoint) {
  let grabbed = null;
  target.addEventListener("pointerdown", (event) => {
    grabbed = event.clientX;
    target.setPointerCapture(event.pointerId);
  });
  target.addEventListener("pointermove", (event) => {
    if (grabbed === null || event.buttons === 0) return onPoint(event);
    const by = toValue(grabbed) - toValue(event.clientX);
    grabbed = event.clientX;
    view.show(view.from + by, view.to + by);
  });
  target.addEventListener("pointerup", () => { grabbed = null; });
  target.addEventListener("pointercancel", () => { grabbed = null; });
  target.addEventListener("pointerleave", () => view.point(null));
  target.addEventListener("dblclick", (event) => view.zoom(0.5, toValue(event.clientX)));
  target.addEventListener("wheel", (event) => {
    // Without a key the wheel moves the page.
    if (!event.ctrlKey && document.activeElement !== target) return;
    event.preventDefault();
    view.zoom(event.deltaY > 0 ? 1.25 : 0.8, toValue(event.clientX));
  }, { passive: false });
  target.addEventListener("keydown", (event) => {
    const action = {
      "+": () => view.zoom(0.5), "-": () => view.zoom(2), "0": () => view.all(),
      ArrowLeft: () => view.move(-0.25), ArrowRight: () => view.move(0.25),
    }[event.key];
    if (!action || event.ctrlKey) return;
    event.preventDefault();
    action();
  });
}

// Width for paper, in CSS pixels, while the page is printed.
let printWidth = null;

// A picture over one view: its coordinates, as wide as there is room.
class Picture {
  constructor(host, view, label) {
    this.view = view;
    this.figure = element(host, "div", { class: "chart" });
    this.head = element(this.figure, "p", { class: "chart-head" });
    this.svg = element(this.figure, "svg", { tabindex: 0, role: "img", "aria-label": label });
    view.charts.push(this);
    gestures(this.svg, view, (px) => this.valueAt(px), (event) => this.read(event));
  }
  width() { return printWidth ?? Math.max(160, this.figure.clientWidth); }
  x(value) { return LEFT + ((value - this.view.from) / (this.view.to - this.view.from)) * (this.width() - LEFT - RIGHT); }
  valueAt(px) {
    const left = this.svg.getBoundingClientRect().left;
    return this.view.from + ((px - left - LEFT) / (this.width() - LEFT - RIGHT)) * (this.view.to - this.view.from);
  }
  clear(height) {
    clear(this.svg, this.width(), height);
    drawGrid(this.svg, this.view, (value) => this.x(value), this.width(), height);
  }
  point() {}
}

function clear(svg, width, height) {
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.setAttribute("width", width);
  svg.setAttribute("height", height);
  svg.textContent = "";
}

// One chart: a title with its unit, a legend that shows the values under the pointer, and the curves.
class Chart extends Picture {
  constructor(host, { title, unit, height, curves, atLeast, marks = [], view, dots = [] }) {
    super(host, view, title + " over time");
    Object.assign(this, { height, curves, atLeast, marks, dots });
    element(this.head, "span", { class: "chart-title" }, title + (unit ? ", " + unit : ""));
    this.readings = curves.map((curve) => {
      const item = element(this.head, "span", { class: "key " + curve.class }, curve.name);
      return element(item, "b");
    });
    this.time = element(this.head, "span", { class: "chart-time" });
    this.draw();
  }
  read(event) { this.view.point(this.valueAt(event.clientX)); }
  range() {
    let [least, most] = this.atLeast;
    for (const { x, y } of this.curves) {
      const end = Math.min(y.length, placeOf(x, this.view.to) + 1);
      for (let n = Math.max(0, placeOf(x, this.view.from) - 1); n < end; n++) {
        if (y[n] < least) least = y[n];
        if (y[n] > most) most = y[n];
      }
    }
    if (!(most > least)) [least, most] = [(Number.isFinite(least) ? least : 0) - 0.5, (Number.isFinite(most) ? most : 0) + 0.5];
    const room = 0.06 * (most - least);
    return [least === this.atLeast[0] && least === 0 ? 0 : least - room, most + room];
  }
  draw() {
    const width = this.width(), height = this.height, bottom = height - BOTTOM;
    const [least, most] = this.range();
    this.y = (value) => bottom - ((value - least) / (most - least)) * (bottom - TOP);
    this.clear(height);
    const { step, result } = ticks(least, most, (bottom - TOP) / 28);
    for (const value of result) {
      const y = this.y(value);
      element(this.svg, "line", { class: "grid", x1: LEFT, x2: width - RIGHT, y1: y, y2: y });
      element(this.svg, "text", { class: "label y", x: LEFT - 6, y: Math.max(TOP + 4, Math.min(bottom, y + 4)) }, tickText(value, step));
    }
    for (const [at, kind] of this.marks) {
      if (at < this.view.from || at > this.view.to) continue;
      element(this.svg, "line", { class: "mark " + kind, x1: this.x(at), x2: this.x(at), y1: TOP, y2: bottom });
    }
    for (const curve of this.curves) {
      element(this.svg, "path", { class: "curve " + curve.class, d: pathOf(curve, this.view, (v) => this.x(v), this.y, width) });
    }
    for (const [at, value, kind] of this.dots) {
      if (at < this.view.from || at > this.view.to) continue;
      element(this.svg, "circle", { class: "dot " + kind, cx: this.x(at), cy: this.y(value), r: 3 });
    }
    this.cursor = element(this.svg, "line", { class: "cursor", y1: TOP, y2: bottom, visibility: "hidden" });
    this.point();
  }
  point() {
    const at = this.view.cursor;
    const isShown = at !== null && at >= this.view.from && at <= this.view.to;
    this.cursor.setAttribute("visibility", isShown ? "visible" : "hidden");
    this.time.textContent = isShown ? at.toFixed(4) + " s" : "";
    if (isShown) for (const end of ["x1", "x2"]) this.cursor.setAttribute(end, this.x(at));
    this.curves.forEach(({ x, y }, n) => {
      const place = isShown ? nearest(x, at) : -1;
      this.readings[n].textContent = place < 0 ? "" : " " + text(y[place]);
    });
  }
}

// The lines of the time and their labels, of which none is cut off or covers another.
function drawGrid(svg, view, x, width, height) {
  const bottom = height - BOTTOM;
  const { step, result } = ticks(view.from, view.to, (width - LEFT) / 80);
  for (const value of result) {
    element(svg, "line", { class: "grid", x1: x(value), x2: x(value), y1: TOP, y2: bottom });
    const label = tickText(value, step), half = label.length * 3.6;
    if (x(value) + half > width - RIGHT - 8 || x(value) - half < LEFT - 14) continue;
    element(svg, "text", { class: "label x", x: x(value), y: bottom + 15 }, label);
  }
  element(svg, "text", { class: "label unit", x: width - 2, y: bottom + 15 }, view.unit ?? "s");
  element(svg, "path", { class: "frame", d: `M${LEFT} ${TOP}V${bottom}H${width - RIGHT}` });
}

// In each column of pixels the first, the least, the most and the last point: every spike stays.
function pathOf({ x, y }, view, toX, toY, width) {
  const begin = Math.max(0, placeOf(x, view.from) - 1), end = Math.min(x.length, placeOf(x, view.to) + 1);
  let path = "", column = null;
  const put = (px, value) => { path += (path ? "L" : "M") + px.toFixed(1) + " " + toY(value).toFixed(1); };
  const flush = () => {
    if (!column) return;
    put(column.px, column.first);
    if (column.least !== column.first || column.most !== column.first || column.last !== column.first) {
      put(column.px, column.least);
      put(column.px, column.most);
      put(column.px, column.last);
    }
  };
  for (let n = begin; n < end; n++) {
    const px = Math.min(Math.max(toX(x[n]), LEFT - 1), width - RIGHT + 1), pixel = Math.round(px);
    if (column && column.pixel === pixel) {
      column.least = Math.min(column.least, y[n]);
      column.most = Math.max(column.most, y[n]);
      column.last = y[n];
    } else {
      flush();
      column = { pixel, px, first: y[n], least: y[n], most: y[n], last: y[n] };
    }
  }
  flush();
  return path;
}
