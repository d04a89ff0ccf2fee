// The charts of the axes and of the bus.

// A log may count from any moment.
const beginS = isLog ? (times[0] ?? 0) : 0;
const timeView = new View(beginS, Math.max(endS + 0.002 * (endS - beginS), beginS + 1e-3), 1e-4);

const isOf = (axis) => (event) => event[1] === null || event[1] === axis;
const marksOf = (axis) => data.events
  .filter((event) => isOf(axis)(event) && ["phase", "commanded", "fault"].includes(event[2]))
  .map((event) => [event[0] / 1e6, event[2]]);

function chartsOf(host, axis) {
  const { about, target, sent, motor, error, backlog, statusAge, positionAge, setPointVelocity, motorVelocity } = axes[axis];
  const figure = element(host, "figure", { class: "axis" });
  element(figure, "figcaption", {}, name(axis));
  const marks = marksOf(axis), unit = about.unit, none = [Infinity, -Infinity];
  const chart = (title, unit, height, curves, atLeast = none) =>
    new Chart(figure, { title, unit, height, curves, atLeast, marks, view: timeView });
  const curve = (name, kind, points) => ({ name, class: kind, ...points });
  const wheel = isSpeed ? "wheel" : "motor";
  chart(isSpeed ? "speed" : "position", unit, 220, [
    ...(isLog ? [] : [curve("target", "target", target)]),
    curve(isLog ? "set-points" : "sent", "sent", sent),
    curve(wheel, "drive", motor),
  ]);
  if (!isSpeed) chart("velocity", unit + "/s", 150, [
    curve("set-points", "sent", setPointVelocity),
    curve("motor", "drive", motorVelocity),
  ]);
  chart(isSpeed ? "speed error" : "following error", unit, 130, [curve(`${isLog ? "set-points" : "target"} \u2212 ${wheel}`, "error", error)]);
  if (isLog) return;
  chart("backlog", isSpeed ? unit : "counts", 100, [curve("target \u2212 sent", "backlog", backlog)], [-1, 1]);
  chart("age of the readings", "ms", 110, [
    curve("status", "status-age", statusAge),
    curve("position", "position-age", positionAge),
  ], [0, 1]);
}

function busCharts(host) {
  const late = data.samples.late.map((place) => [times[place], loads[place], "fault"]);
  new Chart(host, {
    title: "bus load", unit: "%", height: 150, view: timeView, dots: late, atLeast: [0, 10],
    curves: [{ name: data.loadIsLeast ? "busy, without stuff bits" : "busy", class: "bus", x: times, y: loads }],
  });
  new EventRows(host);
}

// A dot for each event in the row of its axis.
class EventRows extends Picture {
  constructor(host) {
    super(host, timeView, "events over time");
    element(this.head, "span", { class: "chart-title" }, "events");
    for (const kind of ["commanded", "fault", "notice", "state"]) element(this.head, "span", { class: "key " + kind }, kind);
    this.reading = element(this.figure, "p", { class: "reading" }, "\u00a0");
    this.rows = [null, ...axes.keys()];
    this.draw();
  }
  draw() {
    const width = this.width(), height = TOP + 22 * this.rows.length + BOTTOM;
    this.clear(height);
    const middle = (row) => TOP + 22 * row + 11;
    this.rows.forEach((axis, row) => {
      const label = axis === null ? "bus" : driveWord + " " + axes[axis].about.drive;
      element(this.svg, "text", { class: "label y", x: LEFT - 6, y: middle(row) + 4 }, label);
    });
    // What matters most is drawn last, over the others, and is small enough to leave them in sight.
    const kinds = [["phase", 3], ["state", 3], ["commanded", 7], ["notice", 3], ["fault", 4]];
    for (const [kind, r] of kinds) {
      for (const event of data.events) {
        const at = event[0] / 1e6;
        if (event[2] !== kind || at < timeView.from || at > timeView.to) continue;
        element(this.svg, "circle", { class: "dot " + kind, cx: this.x(at), cy: middle(this.rows.indexOf(event[1])), r });
      }
    }
  }
  read(pointer) {
    const box = this.svg.getBoundingClientRect();
    const at = this.valueAt(pointer.clientX), row = this.rows[Math.floor((pointer.clientY - box.top - TOP) / 22)];
    const slack = ((timeView.to - timeView.from) / this.width()) * 8;
    const near = data.events
      .filter((event) => event[1] === row && Math.abs(event[0] / 1e6 - at) <= slack)
      .sort((a, b) => Math.abs(a[0] / 1e6 - at) - Math.abs(b[0] / 1e6 - at))[0];
    this.reading.textContent = near ? eventText(near) : "\u00a0";
    timeView.point(at);
  }
}

const eventText = ([us, axis, , what, times]) =>
  (us / 1e6).toFixed(6) + " s  " + (axis === null ? "" : driveWord + " " + axes[axis].about.drive + ": ") + what + (times > 1 ? ` (${times} times)` : "");

// How far the set-points of each axis are from an even rhythm. One late set-point in a million shall be seen: the counts are
// on a logarithmic axis.
class Jitter extends Picture {
  constructor(host) {
    const values = data.deviationsUs;
    const all = values.map(([us]) => us), [least, most] = [Math.min(0, all[0] ?? 0), Math.max(0, all.at(-1) ?? 0)];
    const room = Math.max(5, (most - least) * 0.03);
    const view = new View(least - room, most + room, 5);
    view.unit = "us";
    super(host, view, "histogram of the intervals");
    this.values = values;
    element(this.head, "span", { class: "chart-title" }, "set-points by their interval less the cycle, us; logarithmic");
    this.reading = element(this.figure, "p", { class: "reading" }, "\u00a0");
    this.draw();
  }
  draw() {
    const width = this.width(), height = 200, bottom = height - BOTTOM;
    this.binUs = niceStep(Math.max(1, (this.view.to - this.view.from) / 60));
    this.bins = new Map();
    for (const [us, count] of this.values) {
      const bin = Math.round(us / this.binUs);
      this.bins.set(bin, (this.bins.get(bin) ?? 0) + count);
    }
    const most = Math.max(10, ...this.bins.values()) * 2;
    const y = (count) => bottom - (Math.log(count / 0.5) / Math.log(most / 0.5)) * (bottom - TOP);
    this.clear(height);
    for (let count = 1; count <= most; count *= 10) {
      element(this.svg, "line", { class: "grid", x1: LEFT, x2: width - RIGHT, y1: y(count), y2: y(count) });
      element(this.svg, "text", { class: "label y", x: LEFT - 6, y: y(count) + 4 }, count >= 1e6 ? count.toExponential(0) : String(count));
    }
    for (const [bin, count] of this.bins) {
      const left = Math.max(LEFT, this.x((bin - 0.46) * this.binUs)), right = Math.min(width - RIGHT, this.x((bin + 0.46) * this.binUs));
      if (right <= left) continue;
      element(this.svg, "rect", { class: "bar", x: left, y: y(count), width: Math.max(1, right - left), height: bottom - y(count) });
    }
  }
  read(pointer) {
    const bin = Math.round(this.valueAt(pointer.clientX) / this.binUs), count = this.bins.get(bin) ?? 0;
    this.reading.textContent = `${text(bin * this.binUs)} us: ${count} set-points`;
  }
}
