// The words and the tables, from the same numbers as the charts.

function facts() {
  document.title = data.title;
  document.querySelector("h1").textContent = data.title;
  const verdict = document.getElementById("verdict");
  verdict.textContent = data.verdict.text;
  verdict.className = "verdict " + (data.verdict.good ? "kept" : "broken");
  const about = document.getElementById("about");
  for (const [key, value] of data.about) {
    element(about, "dt", {}, key);
    element(about, "dd", {}, value);
  }
  const list = document.getElementById("facts");
  for (const fact of data.facts) element(list, "p", {}, fact);
  if (firstFault) element(list, "p", { class: "first-fault" }, "First fault, where the charts begin: " + eventText(firstFault));
}

function axisTable() {
  const columns = [
    ["axis", (axis) => axis.about.name, true],
    [driveWord, (axis) => axis.about.drive],
    ["unit", (axis) => axis.about.unit, true],
    ["set-points", (axis) => axis.about.setPoints],
    [isLog ? "set-points at the end" : "target at the end", (axis) => text(lastOf(axis.target.y))],
    ["sent at the end", (axis) => (isLog ? null : text(lastOf(axis.sent.y)))],
    [isSpeed ? "wheel at the end" : "motor at the end", (axis) => text(lastOf(axis.motor.y))],
    ["sum of the steps, counts", (axis) => (isSpeed ? null : sumOfSteps(axis))],
    ["received, counts", (axis) => axis.about.receivedCounts],
    [isSpeed ? "largest speed error" : "largest following error", (axis) => text(largest(axis.error.y))],
    isSpeed ? ["largest speed", (axis) => text(largest(axis.target.y))] : ["largest velocity", (axis) => text(largest(axis.setPointVelocity.y))],
    ["oldest status, ms", (axis) => (isLog ? null : text(largest(axis.statusAge.y)))],
    ["reply timeouts", (axis) => axis.about.replyTimeouts],
    ["state", (axis) => axis.about.state, true],
  ].filter(([, value]) => axes.some((axis) => value(axis) !== null && value(axis) !== undefined && value(axis) !== ""));
  fill(document.getElementById("axes-table"), columns, axes);
}

// What the set-points add up to, from the begin of the motion.
function sumOfSteps(axis) {
  const counts = series(axis.about.sent);
  return counts.length ? counts[counts.length - 1] - counts[startIndex] : 0;
}

const MOST_EVENTS = 1000;

function eventTable() {
  const columns = [
    ["time, s", (event) => (event[0] / 1e6).toFixed(6)],
    [driveWord, (event) => (event[1] === null ? "" : axes[event[1]].about.drive)],
    ["kind", (event) => event[2], true],
    ["what", (event) => event[3] + (event[4] > 1 ? ` (${event[4]} times)` : ""), true],
  ];
  fill(document.getElementById("events"), columns, data.events.slice(0, MOST_EVENTS), (event) => event[2]);
  const left = data.events.length - MOST_EVENTS + data.eventsLeftOut;
  if (left > 0 && data.events.length > 0) document.getElementById("events-more").textContent = `and ${Math.max(left, data.eventsLeftOut)} more`;
}

// On a narrow screen each cell carries the name of its column.
function fill(table, columns, rows, kind = () => "") {
  const head = element(element(table, "thead"), "tr");
  for (const [label, , isWords] of columns) element(head, "th", isWords ? { class: "words" } : {}, label);
  const body = element(table, "tbody");
  for (const row of rows) {
    const line = element(body, "tr");
    for (const [label, value, isWords] of columns) {
      element(line, "td", { "data-label": label, class: (isWords ? "words " : "") + kind(row) }, String(value(row) ?? "-"));
    }
  }
}
