"use strict";
// Draws SCENE (page.py) with WebGL: no library, nothing fetched.
const $ = (id) => document.getElementById(id);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const n = SCENE.bodies.length, joints = SCENE.rims.length, time = SCENE.time, last = time.length - 1;
const U = new Float32Array(bytes(SCENE.u)), TURN = new Float32Array(bytes(SCENE.turn));
const CONTACT = new Uint16Array(bytes(SCENE.contact)), PRESSURE = new Uint16Array(bytes(SCENE.pressure)); // 65535: all
const BASE = SCENE.base ? new Float32Array(bytes(SCENE.base)) : null;
const canvas = $("view"), gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
const state = { t: 0, playing: false, speed: 1, factor: SCENE.factor, chosen: -1, moving: false, again: false, by: "contact", yaw: -1.0, pitch: 0.3, far: 1, shift: [0, 0] };
const SCALES = { contact: [CONTACT, "#d64d0d", "#547da3"], pressure: [PRESSURE, "#e8dfc8", "#7a1f5c"] }; // of 0, of all
const rgb = (text) => text.trim().match(/\w\w/g).map((v) => parseInt(v, 16) / 255);

// poses: displacement and rotation between two rows; a rotation that jumps by a full turn is not blended
function row(t) {
  let a = 0, b = last;
  while (b - a > 1) { const m = (a + b) >> 1; if (time[m] <= t) a = m; else b = m; }
  const part = last ? Math.min(1, Math.max(0, (t - time[a]) / (time[b] - time[a]))) : 0;
  return [a, b, part];
}
function pose(i, [a, b, part]) {
  const at = (rows, k) => [0, 1, 2].map((c) => rows[3 * (k * n + i) + c]);
  const [ta, tb] = [at(TURN, a), at(TURN, b)], jumps = Math.hypot(...ta.map((x, c) => x - tb[c])) > 1.5;
  const mix = (x, y, p) => x.map((v, c) => v + p * (y[c] - v));
  return { u: mix(at(U, a), at(U, b), part), turn: mix(ta, tb, jumps ? Math.round(part) : part) };
}
function base([a, b, part]) { // displacement of the base as it is drawn
  if (!BASE || !state.moving) return [0, 0, 0];
  return [0, 1, 2].map((c) => state.factor * (BASE[3 * a + c] + part * (BASE[3 * b + c] - BASE[3 * a + c])));
}
function matrix(i, where) { // of body i, by columns
  const o = base(where), { u, turn } = pose(i, where), f = state.factor, c = SCENE.bodies[i].centroid;
  const angle = f * Math.hypot(...turn), [x, y, z] = angle ? turn.map((v) => v * f / angle) : [0, 0, 1];
  const s = Math.sin(angle), k = Math.cos(angle), m = 1 - k;
  return [k + m * x * x, m * x * y + s * z, m * x * z - s * y, 0, m * x * y - s * z, k + m * y * y, m * y * z + s * x, 0,
    m * x * z + s * y, m * y * z - s * x, k + m * z * z, 0, ...c.map((v, k) => v + f * u[k] + o[k]), 1];
}
const times = (A, B) => Array.from({ length: 16 }, (_, k) =>
  [0, 1, 2, 3].reduce((sum, j) => sum + A[4 * j + k % 4] * B[4 * (k >> 2) + j], 0));
function camera() {
  const { yaw, pitch, far, shift } = state, [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const aspect = canvas.width / canvas.height, view = 1 / Math.tan(0.35), dist = far * SCENE.extent * 1.55 * Math.max(1, 0.9 / aspect);
  const right = [-sy, cy, 0], back = [cp * cy, cp * sy, sp], up = [-sp * cy, -sp * sy, cp];
  const eye = back.map((v, c) => SCENE.middle[c] + dist * v - shift[0] * right[c] - shift[1] * up[c]);
  const dot = (a) => -a.reduce((sum, v, c) => sum + v * eye[c], 0);
  const look = [0, 1, 2].flatMap((c) => [right[c], up[c], back[c], 0]).concat([dot(right), dot(up), dot(back), 1]);
  const [near, end] = [0.02 * dist, 20 * dist];
  return times([view / aspect, 0, 0, 0, 0, view, 0, 0, 0, 0, (near + end) / (near - end), -1, 0, 0, 2 * near * end / (near - end), 0], look);
}

// drawing
const CELL = ((size) => { const ten = 10 ** Math.floor(Math.log10(size)); return ten * ([5, 2, 1].find((k) => k * ten <= size) || 1); })(SCENE.extent / 5); // m
let program, meshes, rims, walls, ground, grid, triad, place;
function shader(kind, text) {
  const made = gl.createShader(kind);
  gl.shaderSource(made, text); gl.compileShader(made); gl.attachShader(program, made);
}
function buffer(values) {
  const made = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, made); gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.STATIC_DRAW);
  return { made, count: values.length / 6 };
}
function normal(p) {
  const sum = [0, 0, 0];
  for (let k = 1; k + 1 < p.length; k++) {
    const a = p[k].map((v, c) => v - p[0][c]), b = p[k + 1].map((v, c) => v - p[0][c]);
    for (let c = 0; c < 3; c++) sum[c] += a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
  }
  const size = Math.hypot(...sum) || 1;
  return sum.map((v) => v / size);
}
function build() {
  program = gl.createProgram();
  shader(gl.VERTEX_SHADER, `attribute vec3 p; attribute vec3 q; uniform mat4 body, eye; varying vec3 side;
    void main() { side = mat3(body) * q; gl_Position = eye * body * vec4(p, 1.0); }`);
  shader(gl.FRAGMENT_SHADER, `precision mediump float; varying vec3 side; uniform vec3 colour; uniform float lit;
    void main() { float light = 0.68 + 0.24 * side.z + 0.18 * dot(side, vec3(0.6, -0.8, 0.0));
      gl_FragColor = vec4(colour * mix(1.0, light, lit), 1.0); }`);
  gl.linkProgram(program); gl.useProgram(program);
  place = Object.fromEntries(["body", "eye", "colour", "lit"].map((name) => [name, gl.getUniformLocation(program, name)]));
  meshes = SCENE.bodies.map(({ surfaces, mesh }) => {
    const fill = [], lines = [], points = mesh ? new Float32Array(bytes(mesh)) : [];
    for (let k = 0; k < points.length; k += 9) {
      const corners = [0, 3, 6].map((m) => [...points.slice(k + m, k + m + 3)]), q = normal(corners);
      for (const corner of corners) fill.push(...corner, ...q);
    }
    for (const [edged, p] of surfaces) {
      const q = normal(p);
      for (let k = 1; k + 1 < p.length; k++) for (const corner of [p[0], p[k], p[k + 1]]) fill.push(...corner, ...q);
      if (edged) p.forEach((corner, k) => lines.push(...corner, ...q, ...p[(k + 1) % p.length], ...q));
    }
    return { fill: buffer(fill), lines: buffer(lines) };
  });
  rims = SCENE.rims.map(({ points }) => { // a band around the joint, a little outside of the blocks
    const m = [0, 1, 2].map((c) => points.reduce((sum, p) => sum + p[c], 0) / points.length), q = normal(points), found = [];
    const half = Math.max(0.02 * SCENE.band, 0.0035 * SCENE.extent), out = points.map((p) => p.map((v, c) => v + (v - m[c]) * 0.012));
    out.forEach((a, k) => {
      const b = out[(k + 1) % out.length], up = (p, s) => p.map((v, c) => v + s * half * q[c]);
      for (const corner of [up(a, -1), up(b, -1), up(b, 1), up(a, -1), up(b, 1), up(a, 1)]) found.push(...corner, ...q);
    });
    return buffer(found);
  });
  walls = SCENE.walls.map((p) => {
    const q = normal(p), corners = (places) => buffer(places.flatMap((k) => [...p[k], ...q]));
    return { q, fill: corners([0, 1, 2, 0, 2, 3]), lines: corners([0, 1, 1, 2, 2, 3, 3, 0]) };
  });
  const [x, y] = SCENE.middle, cells = Math.ceil(0.9 * SCENE.extent / CELL), r = cells * CELL, z = -0.002 * SCENE.extent;
  ground = buffer([[-r, -r], [r, -r], [r, r], [-r, -r], [r, r], [-r, r]].flatMap(([a, b]) => [x + a, y + b, z, 0, 0, 1]));
  const lines = [];
  for (let k = -cells; k <= cells; k++) for (const [a, b] of [[k * CELL, -r], [k * CELL, r], [-r, k * CELL], [r, k * CELL]]) lines.push(x + a, y + b, z, 0, 0, 1);
  grid = buffer(lines);
  triad = buffer([0, 1, 2].flatMap((k) => [0, 0, 0, 0, 0, 1, ...[0, 1, 2].map((c) => (c === k ? 1 : 0)), 0, 0, 1]));
  gl.enable(gl.DEPTH_TEST); gl.enable(gl.POLYGON_OFFSET_FILL); gl.polygonOffset(1, 1);
}
function put({ made, count }, kind, body, colour, lit) {
  gl.bindBuffer(gl.ARRAY_BUFFER, made);
  for (const [name, from] of [["p", 0], ["q", 12]]) {
    const where = gl.getAttribLocation(program, name);
    if (where >= 0) { gl.enableVertexAttribArray(where); gl.vertexAttribPointer(where, 3, gl.FLOAT, false, 24, from); }
  }
  gl.uniformMatrix4fv(place.body, false, body); gl.uniform3fv(place.colour, colour); gl.uniform1f(place.lit, lit);
  gl.drawArrays(kind, 0, count);
}
const colours = () => { const style = getComputedStyle(document.body); return (name) => rgb(style.getPropertyValue(name)); };
const coded = (k) => [((k + 1) & 255) / 255, (k + 1 >> 8) / 255, 0];
function axes() { // in a corner: x, y, z as they are seen
  const { yaw, pitch } = state, ratio = canvas.width / canvas.clientWidth, size = 64 * ratio, left = canvas.width - size - 8 * ratio;
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)], none = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  gl.viewport(left, 8 * ratio, size, size);
  gl.uniformMatrix4fv(place.eye, false, [-0.7 * sy, -0.7 * sp * cy, 0, 0, 0.7 * cy, -0.7 * sp * sy, 0, 0, 0, 0.7 * cp, 0, 0, 0, 0, -1, 1]);
  put(triad, gl.LINES, none, rgb(getComputedStyle(document.body).getPropertyValue("--ink")), 0);
  [[-sy, -sp * cy], [cy, -sp * sy], [0, cp]].forEach(([a, b], k) => {
    const letter = $("axes").children[k];
    letter.style.left = `${32 + 30 * a}px`; letter.style.bottom = `${32 + 30 * b}px`;
  });
}
let beside = null;
function sharp() { // a picture beside the canvas whose edges mix no colours
  if (beside && beside.width === canvas.width && beside.height === canvas.height) return beside.frame;
  const { width, height } = canvas, frame = gl.createFramebuffer(), colour = gl.createTexture(), depth = gl.createRenderbuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.bindTexture(gl.TEXTURE_2D, colour);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour, 0);
  gl.bindRenderbuffer(gl.RENDERBUFFER, depth); gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, width, height);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  beside = { width, height, frame };
  return frame;
}
function draw(numbers = false) { // numbers: bodies and joints in colours of their numbers, to find what is clicked
  const of = colours(), where = row(state.t), bodies = SCENE.bodies.map((_, i) => matrix(i, where));
  gl.bindFramebuffer(gl.FRAMEBUFFER, numbers ? sharp() : null);
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(...(numbers ? [0, 0, 0] : of("--paper")), 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniformMatrix4fv(place.eye, false, camera());
  if (numbers) {
    bodies.forEach((body, i) => put(meshes[i].fill, gl.TRIANGLES, body, coded(i), 0));
    SCENE.rims.forEach(({ body }, j) => put(rims[j], gl.TRIANGLES, bodies[body], coded(n + j), 0));
    return;
  }
  const shaken = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...base(where), 1], [stone, edge, chosen] = ["--stone", "--edge", "--chosen"].map(of);
  put(ground, gl.TRIANGLES, shaken, of("--ground"), 0);
  put(grid, gl.LINES, shaken, of("--grid"), 0);
  const { yaw, pitch } = state, back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
  for (const wall of walls) { // of one that is seen from behind only its edges: blocks stand beyond it
    if (wall.q.reduce((sum, v, c) => sum + v * back[c], 0) > 0) put(wall.fill, gl.TRIANGLES, shaken, of("--ground"), 1);
    put(wall.lines, gl.LINES, shaken, edge, 0);
  }
  bodies.forEach((body, i) => {
    put(meshes[i].fill, gl.TRIANGLES, body, i === state.chosen ? chosen : stone, 1);
    put(meshes[i].lines, gl.LINES, body, edge, 0);
  });
  const nearest = where[2] < 0.5 ? where[0] : where[1], [values, ...ends] = SCALES[state.by], [least, most] = ends.map(rgb);
  SCENE.rims.forEach(({ body }, j) => {
    const part = values[nearest * joints + j] / 65535;
    put(rims[j], gl.TRIANGLES, bodies[body], j + n === state.chosen ? chosen : least.map((v, c) => v + part * (most[c] - v)), 0);
  });
  axes();
}
function partAt(x, y) { // number of the body, or n and that of the joint, at a place of the page, px; -1: none
  const box = canvas.getBoundingClientRect(), found = new Uint8Array(4), ratio = canvas.width / box.width;
  draw(true);
  gl.readPixels((x - box.left) * ratio, canvas.height - 1 - (y - box.top) * ratio, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);
  draw();
  return found[0] + 256 * found[1] - 1;
}

// the history of what is chosen
const pascals = (value) => value >= 1e5 ? `${(value / 1e6).toPrecision(3)} MPa` : `${(value / 1e3).toPrecision(3)} kPa`;
function histories() { // name, words, and lines: colour and values
  const i = state.chosen, j = i - n, whole = (rows) => time.map((_, k) => rows[k * joints + j] / 65535);
  if (j < 0) return [SCENE.bodies[i].name, ", centroid, mm: ", ["ux", "uy", "uz"].map((name, c) => [name, time.map((_, k) => 1e3 * U[3 * (k * n + i) + c])])];
  const pressure = whole(PRESSURE), most = Math.max(...pressure) || 1;
  return [SCENE.rims[j].name, ": ", [["contact", whole(CONTACT)], [`pressure, of ${pascals(most * SCENE.most)}`, pressure.map((v) => v / most)]]];
}
function plot() {
  const paper = $("plot"), ink = paper.getContext("2d"), ratio = devicePixelRatio || 1;
  $("history").hidden = state.chosen < 0;
  if (state.chosen < 0) return;
  const [name, words, lines] = histories(), style = getComputedStyle(document.body), text = style.getPropertyValue("--ink");
  $("chosen").textContent = name; $("words").textContent = words;
  $("names").replaceChildren(...lines.map(([label], c) => { const one = document.createElement("span"); one.className = `line${c}`; one.textContent = `${label} `; return one; }));
  const [w, h] = [paper.clientWidth, paper.clientHeight];
  paper.width = w * ratio; paper.height = h * ratio; ink.scale(ratio, ratio);
  const flat = lines.flatMap(([, one]) => one), low = flat.reduce((a, b) => Math.min(a, b), 0), high = flat.reduce((a, b) => Math.max(a, b), low + 1e-9);
  const x = (t) => 44 + (w - 52) * (t - time[0]) / (time[last] - time[0] || 1), y = (v) => 8 + (h - 28) * (high - v) / (high - low);
  ink.font = "11px sans-serif"; ink.fillStyle = text; ink.textAlign = "right";
  for (const v of [low, high]) ink.fillText(v ? v.toPrecision(3) : "0", 40, y(v) + 4);
  ink.textAlign = "left"; ink.fillText(`${Number(time[0].toFixed(2))} s`, 44, h - 4); ink.textAlign = "right"; ink.fillText(`${Number(time[last].toFixed(2))} s`, w - 6, h - 4);
  const line = (points, colour) => {
    ink.strokeStyle = colour; ink.beginPath(); points.forEach(([a, b]) => ink.lineTo(a, b)); ink.stroke();
  };
  line([[44, y(0)], [w - 8, y(0)]], "#8888");
  lines.forEach(([, one], c) => line(one.map((v, k) => [x(time[k]), y(v)]), ["#0072B2", "#E69F00", "#009E73"][c]));
  line([[x(state.t), 8], [x(state.t), h - 20]], text);
}

// the controls
let waiting = false;
function show() { // at the next frame
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; now(); });
}
function now() {
  const ratio = devicePixelRatio || 1, w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  draw(); plot();
  $("time").value = state.t; $("clock").textContent = `${state.t.toFixed(2)} s`;
  $("what").textContent = state.by === "contact" ? "part in contact" : "pressure"; $("most").textContent = state.by === "contact" ? "1" : pascals(SCENE.most);
  $("scale").style.background = `linear-gradient(90deg, ${SCALES[state.by].slice(1).join(", ")})`;
  $("times").textContent = state.factor === 1 ? "drawn to scale" : `drawn ${Number(state.factor.toPrecision(2))} times larger`;
  $("true").textContent = state.factor === 1 ? `× ${SCENE.visible}` : "× 1";
}
function play(on) {
  state.playing = on; $("play").textContent = on ? "Pause" : "Play";
  if (on && state.t >= time[last]) state.t = time[0];
  let before = performance.now();
  const step = (at) => {
    if (!state.playing) return;
    state.t = Math.min(time[last], state.t + state.speed * Math.max(0, at - before) / 1e3); before = at;
    if (state.t >= time[last]) { if (state.again) state.t = time[0]; else play(false); }
    now();
    if (state.playing) requestAnimationFrame(step);
  };
  if (on) requestAnimationFrame(step);
}
function seek(t) { play(false); state.t = t; show(); }
function listen() {
  $("play").onclick = () => play(!state.playing);
  $("time").oninput = (e) => seek(Number(e.target.value));
  $("speed").onchange = (e) => { state.speed = Number(e.target.value); };
  $("factor").oninput = (e) => { state.factor = 10 ** Number(e.target.value); show(); };
  $("by").onchange = (e) => { state.by = e.target.value; show(); };
  $("moving").onchange = (e) => { state.moving = e.target.checked; show(); };
  addEventListener("keydown", (e) => { if (e.key === " " && e.target === document.body) { e.preventDefault(); play(!state.playing); } });
  $("true").onclick = () => { state.factor = state.factor === 1 ? SCENE.visible : 1; $("factor").value = Math.log10(state.factor); show(); };
  $("light").onclick = () => { const dark = getComputedStyle(document.body).colorScheme.includes("dark"); document.body.className = dark ? "light" : "dark"; show(); };
  $("close").onclick = () => { state.chosen = -1; show(); };
  const held = new Map();
  let moved = 0, apart = 0;
  canvas.onpointerdown = (e) => { canvas.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); if (held.size === 1) moved = 0; apart = 0; };
  canvas.onpointermove = (e) => {
    if (!held.has(e.pointerId)) return;
    const [x, y] = held.get(e.pointerId), [dx, dy] = [e.clientX - x, e.clientY - y];
    held.set(e.pointerId, [e.clientX, e.clientY]); moved += Math.hypot(dx, dy);
    if (held.size === 2) { // two fingers: nearer, farther
      const [a, b] = [...held.values()], d = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (apart) state.far *= apart / d;
      apart = d;
    } else if (e.shiftKey || e.buttons === 2) {
      const size = state.far * SCENE.extent * 1.4 / canvas.clientHeight; state.shift[0] += size * dx; state.shift[1] -= size * dy;
    } else { state.yaw -= 0.008 * dx; state.pitch = Math.min(1.55, Math.max(-0.2, state.pitch + 0.008 * dy)); }
    state.far = Math.min(8, Math.max(0.1, state.far)); show();
  };
  canvas.onpointerup = (e) => { held.delete(e.pointerId); if (moved < 4) { state.chosen = partAt(e.clientX, e.clientY); show(); } };
  canvas.onpointercancel = (e) => held.delete(e.pointerId);
  canvas.oncontextmenu = (e) => e.preventDefault();
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); state.far = Math.min(8, Math.max(0.1, state.far * Math.exp(0.001 * e.deltaY))); show(); }, { passive: false });
  addEventListener("resize", show);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
}
function begin() {
  $("time").min = time[0]; $("time").max = time[last]; $("factor").value = Math.log10(state.factor); state.t = SCENE.begin;
  for (const [word, t] of SCENE.marks) {
    const mark = document.createElement("button");
    mark.textContent = `${word} ${t.toFixed(2)} s`; mark.className = "mark"; mark.onclick = () => seek(t);
    mark.style.setProperty("--at", (t - time[0]) / (time[last] - time[0] || 1)); mark.classList.add(word);
    $("marks").append(mark);
  }
  $("moves").hidden = !BASE; $("cell").textContent = `squares of ${CELL} m`;
  if (!gl) { $("none").hidden = false; $("legend").hidden = $("axes").hidden = true; return; }
  build(); $("true").hidden = SCENE.visible === 1 && state.factor === 1; listen(); show();
  if (location.hash === "#play") { state.again = true; state.t = time[0]; play(true); }
}
begin();
