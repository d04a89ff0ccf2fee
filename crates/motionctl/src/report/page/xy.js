// The path of two axes, with the same scale both ways where their units agree.

class Path {
  constructor(host) {
    this.figure = element(host, "figure");
    const controls = element(this.figure, "div", { class: "controls" });
    this.choices = ["horizontal", "vertical"].map((label, n) => {
      const box = element(controls, "label", {}, label + " ");
      const select = element(box, "select");
      axes.forEach((_, axis) => select.add(new Option(name(axis), axis, axis === n, axis === n)));
      select.addEventListener("change", () => this.all());
      return select;
    });
    for (const [label, title, action] of [
      ["+", "zoom in", () => this.zoom(0.5)], ["\u2212", "zoom out", () => this.zoom(2)], ["all", "show the whole path", () => this.all()],
    ]) element(controls, "button", { type: "button", title }, label).addEventListener("click", action);
    const head = element(this.figure, "p", { class: "chart-head" });
    element(head, "span", { class: "key sent" }, isLog ? "set-points" : "target");
    element(head, "span", { class: "key drive" }, "motor");
    this.svg = element(this.figure, "svg", { tabindex: 0, role: "img", "aria-label": "path of two axes" });
    this.reading = element(this.figure, "p", { class: "reading" }, "\u00a0");
    timeView.charts.push(this);
    this.listen();
    this.all();
  }
  axis(n) { return axes[Number(this.choices[n].value)]; }
  width() { return printWidth ?? Math.max(160, this.svg.parentElement.clientWidth - 20); }
  height() { return Math.min(560, Math.max(220, this.width() * 0.6)); }
  all() {
    const range = (values) => values.reduce(([least, most], value) => [Math.min(least, value), Math.max(most, value)], [Infinity, -Infinity]);
    this.centre = [0, 1].map((n) => { const [a, b] = range(this.axis(n).target.y); return Number.isFinite(a) ? (a + b) / 2 : 0; });
    const span = [0, 1].map((n) => { const [a, b] = range(this.axis(n).target.y); return Math.max(b - a, 1e-9) || 1; });
    const room = [this.width() - LEFT - RIGHT, this.height() - TOP - BOTTOM];
    const scale = room.map((px, n) => (px * 0.92) / span[n]);
    const isSame = this.axis(0).about.unit === this.axis(1).about.unit;
    this.scale = isSame ? scale.map(() => Math.min(...scale)) : scale;
    this.draw();
  }
  zoom(factor) {
    this.scale = this.scale.map((scale) => scale / factor);
    this.draw();
  }
  x(value) { return (LEFT + this.width() - RIGHT) / 2 + (value - this.centre[0]) * this.scale[0]; }
  y(value) { return (TOP + this.height() - BOTTOM) / 2 - (value - this.centre[1]) * this.scale[1]; }
  draw() {
    const width = this.width(), height = this.height(), bottom = height - BOTTOM;
    clear(this.svg, width, height);
    const id = "path-area";
    const clip = element(element(this.svg, "defs"), "clipPath", { id });
    element(clip, "rect", { x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: bottom - TOP });
    this.grid(width, bottom);
    const inside = element(this.svg, "g", { "clip-path": `url(#${id})` });
    const [a, b] = [this.axis(0), this.axis(1)];
    element(inside, "path", { class: "curve sent", d: this.line(a.target.x, (n) => a.target.y[n], (n) => b.target.y[n]) });
    // Both motors are known at the same moment in a simulation; on a bus the other one is where it was read last.
    const other = (n) => b.motor.y[Math.max(0, placeOf(b.motor.x, a.motor.x[n] + 1e-9) - 1)] ?? NaN;
    element(inside, "path", { class: "curve drive", d: this.line(a.motor.x, (n) => a.motor.y[n], other) });
    this.spot = element(inside, "circle", { class: "dot sent", r: 5, visibility: "hidden" });
    this.point();
  }
  grid(width, bottom) {
    const reach = (n, px) => px / 2 / this.scale[n];
    const ends = [reach(0, width - LEFT - RIGHT), reach(1, bottom - TOP)].map((by, n) => [this.centre[n] - by, this.centre[n] + by]);
    const across = ticks(...ends[0], (width - LEFT) / 80), up = ticks(...ends[1], (bottom - TOP) / 40);
    for (const value of across.result) {
      const x = this.x(value), label = tickText(value, across.step), half = label.length * 3.6;
      element(this.svg, "line", { class: "grid", x1: x, x2: x, y1: TOP, y2: bottom });
      if (x + half < width - RIGHT - 40 && x - half > LEFT - 14) element(this.svg, "text", { class: "label x", x, y: bottom + 15 }, label);
    }
    for (const value of up.result) {
      element(this.svg, "line", { class: "grid", x1: LEFT, x2: width - RIGHT, y1: this.y(value), y2: this.y(value) });
      element(this.svg, "text", { class: "label y", x: LEFT - 6, y: Math.max(TOP + 4, Math.min(bottom, this.y(value) + 4)) }, tickText(value, up.step));
    }
    element(this.svg, "text", { class: "label unit", x: width - 2, y: bottom + 15 }, this.axis(0).about.unit);
    element(this.svg, "path", { class: "frame", d: `M${LEFT} ${TOP}V${bottom}H${width - RIGHT}` });
  }
  // The part of the path in the time that the other charts show.
  line(at, x, y) {
    let path = "", last = "";
    for (let n = placeOf(at, timeView.from); n < at.length && at[n] <= timeView.to; n++) {
      if (!Number.isFinite(x(n)) || !Number.isFinite(y(n))) continue;
      const place = this.x(x(n)).toFixed(1) + " " + this.y(y(n)).toFixed(1);
      if (place === last) continue;
      path += (path ? "L" : "M") + (last = place);
    }
    return path;
  }
  point() {
    const at = timeView.cursor, place = at === null ? -1 : nearest(times, at);
    this.spot.setAttribute("visibility", place < 0 ? "hidden" : "visible");
    if (place < 0) return;
    this.spot.setAttribute("cx", this.x(this.axis(0).target.y[place]));
    this.spot.setAttribute("cy", this.y(this.axis(1).target.y[place]));
  }
  listen() {
    let grabbed = null;
    this.svg.addEventListener("pointerdown", (event) => {
      grabbed = [event.clientX, event.clientY];
      this.svg.setPointerCapture(event.pointerId);
    });
    this.svg.addEventListener("pointerup", () => { grabbed = null; });
    this.svg.addEventListener("pointermove", (event) => {
      if (grabbed === null || event.buttons === 0) return this.read(event);
      this.centre[0] -= (event.clientX - grabbed[0]) / this.scale[0];
      this.centre[1] += (event.clientY - grabbed[1]) / this.scale[1];
      grabbed = [event.clientX, event.clientY];
      this.draw();
    });
    this.svg.addEventListener("dblclick", () => this.zoom(0.5));
    this.svg.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== this.svg) return;
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.25 : 0.8);
    }, { passive: false });
    this.svg.addEventListener("keydown", (event) => {
      const action = { "+": () => this.zoom(0.5), "-": () => this.zoom(2), "0": () => this.all() }[event.key];
      if (action) action();
    });
  }
  // The nearest point of the target's path.
  read(event) {
    const box = this.svg.getBoundingClientRect(), [px, py] = [event.clientX - box.left, event.clientY - box.top];
    const [a, b] = [this.axis(0), this.axis(1)];
    let best = -1, least = 30 * 30;
    for (let n = placeOf(times, timeView.from); n < times.length && times[n] <= timeView.to; n++) {
      const distance = (this.x(a.target.y[n]) - px) ** 2 + (this.y(b.target.y[n]) - py) ** 2;
      if (distance < least) [best, least] = [n, distance];
    }
    this.reading.textContent = best < 0 ? "\u00a0"
      : `${times[best].toFixed(4)} s: ${text(a.target.y[best])} ${a.about.unit}, ${text(b.target.y[best])} ${b.about.unit}`;
    timeView.point(best < 0 ? null : times[best]);
  }
}
