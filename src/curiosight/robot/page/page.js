"use strict";
// The page asks again and again; nothing is kept but the newest answers.
const PICTURES = ["colour", "teacher", "saliency", "uncertainty"];
const SVG = "http://www.w3.org/2000/svg";
const at = (id) => document.getElementById(id);
let plan = null, live = {}, names = new Map(), frame = null;

const hue = (region) => `hsl(${(region * 137.5 + 200) % 360} 65% var(--lightness))`;
const nameOf = (region) => names.get(region) ?? `region ${region}`;
const number = (value, digits = 2) => (value === null || value === undefined ? "–" : value.toFixed(digits));
const duration = (s) => (s === null ? "–" : s < 1 ? `${Math.round(1000 * s)} ms` : s < 100 ? `${s.toFixed(1)} s` : `${Math.round(s / 60)} min`);

async function ask(path) {
  const answer = await fetch(path, { cache: "no-store" });
  if (!answer.ok) throw new Error(path);
  return answer;
}

async function command(name, value) {
  try {
    const answer = await fetch(`/${name}`, { method: "POST", body: JSON.stringify(value) });
    const told = await answer.json();
    at("said").textContent = told.done ?? told.error;
  } catch {
    at("said").textContent = "no answer";
  }
  await showLive().catch(() => {});
}

function drawn(name, attributes, parent, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "style") element.style.cssText = value; else element.setAttribute(key, value);
  }
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
}

function cell(row, text) {
  const td = document.createElement("td");
  td.textContent = text;
  row.append(td);
  return td;
}

function regionCell(row, region) {
  const td = cell(row, "");
  const dot = document.createElement("span");
  dot.className = "dot";
  dot.style.background = hue(region);
  td.append(dot, nameOf(region));
}

async function showState() {
  const state = await (await ask("/state.json")).json();
  at("state").textContent = state.state;
  at("map_hz").textContent = number(state.map_hz, 1);
  at("learn_hz").textContent = number(state.learn_hz, 1);
  at("map_age_s").textContent = duration(state.map_age_s);
  at("model_age_s").textContent = duration(state.model_age_s);
  at("dropped").textContent = state.dropped ?? "–";
  const hasBegun = state.map_hz !== null && state.state !== "ended";
  for (const id of ["pause", "freeze"]) at(id).disabled = !hasBegun;
  for (const region of state.regions ?? []) names.set(region.id, region.name);
  showWhy(state);
  showRegions(state.regions ?? []);
  showAlarms(state.alarms ?? []);
  if (hasBegun && (plan === null || plan.regions.length === 0)) plan = await (await ask("/plan.json")).json();
}

function showAlarms(alarms) {
  at("changes").hidden = alarms.length === 0;
  at("alarms").replaceChildren(...[...alarms].reverse().map((alarm) => {
    const line = document.createElement("li");
    const where = alarm.place < 0 ? "" : `, place ${alarm.place}`;
    line.textContent = `look ${alarm.look}${where}: ${alarm.reason}`;
    return line;
  }));
}

function showWhy(state) {
  at("goal").textContent = state.goal === null ? "–" : `${nameOf(state.goal)}:`;
  at("text").textContent = state.why?.text ?? "";
  const candidates = state.why?.candidates ?? [];
  at("candidates").hidden = candidates.length === 0;
  const rows = [...candidates].sort((a, b) => b.score - a.score).map((one) => {
    const row = document.createElement("tr");
    if (one.region === state.why.chosen) row.className = "chosen";
    regionCell(row, one.region);
    cell(row, one.expected_gain === null ? "not known" : number(one.expected_gain, 3));
    cell(row, number(one.seconds, 1));
    cell(row, number(one.score, 3));
    return row;
  });
  at("candidates").tBodies[0].replaceChildren(...rows);
}

function showRegions(regions) {
  const body = at("regions").tBodies[0];
  // Rows stay, so that a button can be pressed while numbers change.
  while (body.rows.length > regions.length) body.deleteRow(-1);
  regions.forEach((region, place) => {
    let row = body.rows[place];
    if (!row) {
      row = body.insertRow();
      regionCell(row, region.id);
      for (let i = 0; i < 3; i++) cell(row, "");
      const button = document.createElement("button");
      button.type = "button";
      button.addEventListener("click", () => command("pin", live.pinned === region.id ? null : region.id));
      cell(row, "").append(button);
    }
    row.cells[1].textContent = region.n_looks;
    row.cells[2].textContent = number(region.error);
    row.cells[3].textContent = number(region.progress, 4);
    const button = row.cells[4].firstChild;
    const isPinned = live.pinned === region.id;
    button.textContent = isPinned ? "Unpin" : "Pin";
    button.setAttribute("aria-pressed", isPinned);
  });
}

async function showLive() {
  live = await (await ask("/live.json")).json();
  at("note").textContent = live.frame ? `${live.note}, frame ${live.frame}` : live.note;
  at("pause").setAttribute("aria-pressed", live.is_paused === true);
  at("pause").textContent = live.is_paused ? "Go on" : "Pause";
  at("freeze").setAttribute("aria-pressed", live.is_frozen === true);
  at("freeze").textContent = live.is_frozen ? "Learn again" : "Freeze the model";
  at("freeze").hidden = live.is_learning === false;
  at("save").disabled = !live.can_save;
  if (live.curves) {
    const all = { points: live.curves.error, look: "class" };
    drawCurves(at("error"), [...live.curves.regions.map((r) => ({ points: r.error, region: r.id })), all], 0, 1);
    drawCurves(at("progress"), live.curves.regions.map((r) => ({ points: r.progress, region: r.id })));
  }
  drawPlan();
}

function drawCurves(svg, curves, low, high) {
  const { width, height } = svg.getBoundingClientRect();
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.replaceChildren();
  const points = curves.flatMap((curve) => curve.points);
  const last = Math.max(1, ...points.map((p) => p[0]));
  low ??= Math.min(0, ...points.map((p) => p[1]));
  high ??= Math.max(0.01, ...points.map((p) => p[1]));
  const left = 40, right = 8, top = 10, bottom = 20;
  const x = (s) => left + (s / last) * (width - left - right);
  const y = (v) => top + (1 - (v - low) / (high - low)) * (height - top - bottom);
  for (const value of [...new Set([low, 0, high])]) {
    drawn("line", { class: "axis", x1: left, x2: width - right, y1: y(value), y2: y(value) }, svg);
    drawn("text", { x: left - 5, y: y(value) + 4, "text-anchor": "end" }, svg, String(+value.toFixed(3)));
  }
  drawn("text", { x: width - right, y: height - 5, "text-anchor": "end" }, svg, `${Math.round(last)} s`);
  for (const curve of curves) {
    if (!curve.points.length) continue;
    const path = curve.points.map((p) => `${x(p[0]).toFixed(1)},${y(p[1]).toFixed(1)}`).join(" ");
    const isAll = curve.region === undefined;
    const look = isAll ? { class: "line all" } : { class: "line", style: `stroke:${hue(curve.region)};opacity:.75` };
    drawn("polyline", { points: path, ...look }, svg);
  }
}

function drawPlan() {
  const svg = at("plan");
  svg.replaceChildren();
  const everything = (plan?.regions ?? []).flatMap((r) => r.points).concat((plan?.outlines ?? []).flat());
  svg.style.display = everything.length ? "" : "none";
  if (!everything.length) return;
  const xs = everything.map((p) => p[0]), ys = everything.map((p) => -p[1]);
  const margin = 0.6;
  const west = Math.min(...xs) - margin, north = Math.min(...ys) - margin;
  const width = Math.max(...xs) + margin - west, height = Math.max(...ys) + margin - north;
  svg.setAttribute("viewBox", `${west} ${north} ${width} ${height}`);
  const box = svg.getBoundingClientRect();
  const px = Math.max(width / box.width, height / box.height);  // metres of a pixel
  for (const outline of plan.outlines) {
    drawn("polygon", { class: "wall", points: outline.map((p) => `${p[0]},${-p[1]}`).join(" ") }, svg);
  }
  for (const region of plan.regions) {
    for (const [x, y] of region.points) {
      drawn("circle", { cx: x, cy: -y, r: 2.5 * px, style: `fill:${hue(region.id)}` }, svg);
    }
  }
  if (live.target) drawn("circle", { class: "goal", cx: live.target[0], cy: -live.target[1], r: 9 * px }, svg);
  if (live.robot) {
    const [x, y, heading] = live.robot;
    const tip = (turn, length) => `${x + length * px * Math.cos(heading + turn)},${-(y + length * px * Math.sin(heading + turn))}`;
    drawn("polygon", { class: "robot", points: [tip(0, 14), tip(2.5, 10), tip(Math.PI, 4), tip(-2.5, 10)].join(" ") }, svg);
  }
}

async function showPictures() {
  for (const name of PICTURES) {
    const answer = await fetch(`/${name}.jpg`, { cache: "no-store" });
    if (!answer.ok) { await answer.body?.cancel(); continue; }
    const image = at(name), before = image.src;
    image.src = URL.createObjectURL(await answer.blob());
    image.hidden = false;
    if (before) URL.revokeObjectURL(before);
  }
}

function again(job, every) {
  let wasLost = false;
  const turn = async () => {
    if (!document.hidden) {
      try {
        await job();
        if (wasLost) at("said").textContent = "";
        wasLost = false;
      } catch {
        wasLost = true;
        at("state").textContent = "no answer: it has ended, or cannot be reached";
      }
    }
    setTimeout(turn, every);
  };
  turn();
}

at("pause").addEventListener("click", () => command("pause", !live.is_paused));
at("freeze").addEventListener("click", () => command("freeze", !live.is_frozen));
at("save").addEventListener("click", () => command("save", null));
again(showState, 500);
again(showLive, 1000);
again(showPictures, 250);
