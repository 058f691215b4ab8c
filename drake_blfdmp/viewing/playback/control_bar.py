"""The page's style, its control bar, and the script that fills the scene and drives Meshcat's animation.

The script only reads the JSON that `page` puts into the page. Texts from files (events, names) go in as text, never
as markup. Meshcat's animation mixer keeps the time; the bar shows it and sets it.
"""

STYLE = """
html, body { margin: 0; height: 100%; overflow: hidden; background: #f5f7fa; }
#meshcat-pane { width: 100vw; height: 100vh; overflow: hidden; }
#legend, #bar, #caption, #problem { font: 13px/1.5 system-ui, sans-serif; color: #222; position: fixed; z-index: 5; }
#legend { left: 12px; bottom: 84px; padding: 7px 12px; border-radius: 6px; background: rgba(255,255,255,0.85);
  max-width: min(26em, 70vw); max-height: 45vh; overflow: auto; }
#legend summary { font-weight: 600; cursor: pointer; }
.swatch { display: inline-block; width: 1.1em; height: 0.7em; margin-right: 0.5em; border-radius: 2px; }
#caption { top: 12px; left: 0; right: 0; text-align: center; pointer-events: none; }
#caption > div { display: inline-block; margin: 0 4px; padding: 3px 14px; border-radius: 14px; font-size: 16px;
  font-weight: 600; background: rgba(255,255,255,0.85); transition: background 0.6s; }
#caption > div.hanging { position: fixed; transform: translate(-50%, -100%); }
#caption > div.fresh { background: #fff3c4; transition: none; }
#bar { left: 0; right: 0; bottom: 0; height: 72px; padding: 0 14px; box-sizing: border-box; display: flex; gap: 12px;
  align-items: center; background: rgba(255,255,255,0.92); border-top: 1px solid #c9d0d8; }
#bar button, #bar select { font: inherit; height: 34px; border: 1px solid #b6bfca; border-radius: 6px; background: #fff;
  color: #222; cursor: pointer; }
#bar button:hover, #bar select:hover { border-color: #0072B2; }
#play { width: 44px; font-size: 15px; }
#repeat[aria-pressed="true"] { background: #dcebf6; border-color: #0072B2; }
#line { position: relative; flex: 1; height: 100%; min-width: 80px; }
#time { position: absolute; left: 0; right: 0; top: 38px; width: 100%; margin: 0; accent-color: #0072B2; height: 16px; }
#marks { position: absolute; left: 8px; right: 8px; top: 4px; height: 34px; overflow: visible; }
#marks button { all: unset; position: absolute; transform: translateX(-50%); text-align: center; cursor: pointer;
  font-size: 11px; line-height: 14px; white-space: nowrap; color: #333; height: 32px; }
#marks button::after { content: ""; display: block; width: 2px; margin: 1px auto 0; background: #5A6470; height: 15px; }
#marks button.second { color: #777; }
#marks button.now { font-weight: 700; color: #0072B2; }
#marks button:hover { color: #0072B2; }
#marks button:focus-visible { outline: 2px solid #0072B2; }
#clock { font-variant-numeric: tabular-nums; white-space: nowrap; min-width: 7.5em; text-align: right; }
#problem { top: 40%; left: 0; right: 0; text-align: center; font-size: 16px; }
@media (max-width: 620px) { #bar { gap: 6px; padding: 0 6px; } #clock { min-width: 4em; } #repeat { display: none; } }
"""

BAR = """
<div id="caption" aria-live="polite"></div>
<details id="legend" open><summary></summary></details>
<div id="bar" role="toolbar" aria-label="Playback">
  <button id="play" title="Play or pause (space)" aria-label="Play"></button>
  <div id="line"><div id="marks"></div>
    <input id="time" type="range" min="0" step="any" value="0" aria-label="Time, s"></div>
  <output id="clock" title="Time in the recording, and its end"></output>
  <select id="speed" title="Speed" aria-label="Speed"></select>
  <button id="repeat" title="Start again at the end" aria-pressed="true">repeat</button>
</div>
"""

SCRIPT = r"""
"use strict";
const playback = (() => {
  const KINDS = { 18: Uint8Array, 21: Int32Array, 22: Uint32Array, 23: Float32Array };
  function bytes(text) {
    const raw = atob(text), result = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) result[i] = raw.charCodeAt(i);
    return result;
  }
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const revive = (key, value) =>
    value && value.$kind ? new KINDS[value.$kind](bytes(value.data).buffer) : value;
  const data = JSON.parse(document.getElementById("recording").textContent, revive);
  const element = (id) => document.getElementById(id);
  const animator = viewer.animator, duration = data.duration;

  // The scene.
  for (const command of data.commands) viewer.handle_command(command);
  const spot = viewer.scene_tree.find(["Lights", "SpotLight", "<object>"]).object;
  spot.shadow.mapSize.set(2048, 2048);
  spot.shadow.normalBias = 0.02;  // Less, and surfaces shade themselves in stripes.
  viewer.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  const at = (p) => [p[0], p[2], -p[1]];  // three.js has y up.
  viewer.camera.position.set(...at(data.camera));
  viewer.controls.target.set(...at(data.target));
  viewer.controls.update();

  // The animation. The clock's track lasts as long as the recording, even where nothing moves.
  const times = data.tracks.times.map(floats);
  const clips = Object.assign({}, data.tracks.clips, {
    "/clock": [{ name: "position", type: "vector3", times: null, values: [0, 0, 0, 0, 0, 0] }] });
  const animations = Object.entries(clips).map(([path, tracks]) => ({
    path: path.split("/").filter((name) => name.length > 0),
    clip: { name: "playback", fps: 1, duration: duration, tracks: tracks.map((track) => ({
      name: "." + track.name, type: track.type,
      times: track.times === null ? [0, duration] : times[track.times],
      values: typeof track.values === "string" ? floats(track.values) : track.values })) } }));
  viewer.set_animation(animations, { play: true, repetitions: Infinity, clampWhenFinished: true });
  animator.pause();

  // What it can do.
  let repeat = true, speed = data.speed, shown = -1, shown_playing = null;
  const clip = (t) => Math.max(0, Math.min(duration, t));
  function seek(t) {
    animator.seek(clip(t));
    animator.display_progress(clip(t));
    viewer.set_dirty();
    refresh();
  }
  function play() {
    if (animator.time >= duration) seek(0);
    animator.mixer.timeScale = speed;
    animator.play();
  }
  const pause = () => animator.pause();
  function set_speed(value) {
    speed = value;
    animator.mixer.timeScale = value;
    element("speed").value = String(value);
  }

  // The bar.
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
  for (const value of [...new Set([...SPEEDS, data.speed])].sort((a, b) => a - b)) {
    element("speed").add(new Option(value + " \u00d7", String(value)));
  }
  element("time").max = duration;
  const marks = data.events.map((event) => {
    const mark = document.createElement("button");
    mark.textContent = event.text;
    mark.title = event.label + " (" + (data.start + event.time).toFixed(2) + " s)";
    mark.style.left = (100 * event.time) / duration + "%";
    if (event.file > 0) mark.classList.add("second");
    mark.addEventListener("click", () => seek(event.time));
    element("marks").append(mark);
    return mark;
  });
  // Where there is no room for a text its stroke stays.
  function fit_marks() {
    const width = element("marks").clientWidth;
    let end = -Infinity;
    marks.forEach((mark, i) => {
      mark.textContent = data.events[i].text;
      const middle = (data.events[i].time / duration) * width, half = mark.offsetWidth / 2;
      if (middle - half < end + 4) mark.textContent = "\u00a0"; else end = middle + half;
    });
  }
  const swatch = (colour) => {
    const made = document.createElement("span");
    made.className = "swatch";
    made.style.background = colour;
    return made;
  };
  element("legend").querySelector("summary").textContent = data.title;
  for (const [text, colour] of data.legend) {
    const row = document.createElement("div");
    row.append(swatch(colour), text);
    element("legend").append(row);
  }
  element("legend").open = window.innerWidth > 620;
  const captions = data.files.map((file) => {
    const caption = document.createElement("div");
    caption.classList.toggle("hanging", data.anchors.length > 0);
    element("caption").append(caption);
    return caption;
  });
  function refresh() {
    const t = animator.time;
    if (animator.playing !== shown_playing) {
      shown_playing = animator.playing;
      element("play").textContent = shown_playing ? "❚❚" : "▶";
      element("play").setAttribute("aria-label", shown_playing ? "Pause" : "Play");
    }
    if (t === shown) return;
    shown = t;
    element("time").value = t;
    element("clock").textContent = (data.start + t).toFixed(2) + " / " + (data.start + duration).toFixed(2) + " s";
    captions.forEach((caption, file) => {
      const event = now(file, t), text = event ? event.label : "";
      caption.style.display = text ? "" : "none";
      caption.classList.toggle("fresh", Boolean(event) && t - event.time < 0.8);
      if (caption.textContent !== text) {
        caption.textContent = text;
        if (captions.length > 1 && text && !data.anchors.length) caption.prepend(swatch(data.files[file].colour));
      }
    });
    marks.forEach((mark, i) => mark.classList.toggle("now", data.events[i] === now(data.events[i].file, t)));
  }
  function now(file, t) {
    let last = null;
    for (const event of data.events) if (event.file === file && event.time <= t + 1e-6) last = event;
    return last;
  }
  // Captions of files side by side hang over them.
  function place(anchor, width, height) {
    const seen = new MeshCat.THREE.Vector3(...at(anchor)).project(viewer.camera);
    return [(width * (1 + seen.x)) / 2, (height * (1 - seen.y)) / 2];
  }
  function hang() {
    data.anchors.forEach((anchor, file) => {
      const [x, y] = place(anchor, window.innerWidth, window.innerHeight);
      captions[file].style.left = x + "px";
      captions[file].style.top = y + "px";
    });
  }
  let last = 0;
  function tick() {
    if (animator.playing && !repeat && animator.time < last - duration / 2) {
      pause();
      seek(duration);
    }
    last = animator.time;
    refresh();
    hang();
    requestAnimationFrame(tick);
  }
  element("play").addEventListener("click", () => (animator.playing ? pause() : play()));
  element("time").addEventListener("input", (event) => seek(Number(event.target.value)));
  element("speed").addEventListener("change", (event) => set_speed(Number(event.target.value)));
  element("repeat").addEventListener("click", () => {
    repeat = !repeat;
    element("repeat").setAttribute("aria-pressed", String(repeat));
  });
  window.addEventListener("keydown", (event) => {
    const typing = event.target instanceof Element && event.target.matches("input:not([type=range]), select, button");
    if (typing || event.ctrlKey || event.metaKey) return;
    const step = event.shiftKey ? 1 : 0.1;
    if (event.key === " ") animator.playing ? pause() : play();
    else if (event.key === "ArrowRight") seek(animator.time + step);
    else if (event.key === "ArrowLeft") seek(animator.time - step);
    else if (event.key === "Home") seek(0);
    else if (event.key === "End") seek(duration);
    else return;
    event.preventDefault();
  });

  // Meshcat keeps the upright angle of view; a narrow window would cut the scene off at both sides.
  function fit(width, height) {
    const half = (degrees) => Math.tan((degrees * Math.PI) / 360);
    const across = half(data.field_of_view[1]) / (width / height);
    viewer.camera.fov = (Math.atan(Math.max(half(data.field_of_view[0]), across)) * 360) / Math.PI;
    viewer.set_3d_pane_size(width, height);
  }
  function fit_window() {
    fit(window.innerWidth, window.innerHeight);
    fit_marks();
  }
  window.addEventListener("resize", fit_window);
  window.addEventListener("load", fit_window);

  // One picture for a video: the scene with title, legend and event drawn over it.
  function picture(t, width, height) {
    const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
    canvas.width = width;
    canvas.height = height;
    viewer.renderer.setPixelRatio(1);
    const drawn = viewer.renderer.domElement;
    if (drawn.width !== width || drawn.height !== height) fit(width, height);  // The window's size came in between.
    seek(t);
    viewer.render();
    pen.drawImage(drawn, 0, 0, width, height);
    const unit = Math.round(height / 42);
    pen.font = unit + "px sans-serif";
    pen.textBaseline = "middle";
    const rows = [[data.title, null], ...data.legend];
    const wide = Math.max(...rows.map(([text]) => pen.measureText(text).width)) + 3.4 * unit;
    const tall = (1.5 * rows.length + 0.8) * unit, top = height - tall - unit;
    pen.fillStyle = "rgba(255,255,255,0.8)";
    pen.fillRect(unit, top, wide, tall);
    rows.forEach(([text, colour], row) => {
      const y = top + (1.5 * row + 1.1) * unit;
      if (colour) {
        pen.fillStyle = colour;
        pen.fillRect(1.5 * unit, y - 0.35 * unit, 1.1 * unit, 0.7 * unit);
      }
      pen.fillStyle = "#222";
      pen.fillText(text, (colour ? 3.0 : 1.5) * unit, y);
    });
    const clock = (data.start + t).toFixed(2) + " s" + (data.speed === 1 ? "" : "  " + data.speed + " \u00d7");
    const said = data.files.map((file, k) => now(k, t)).map((event) => (event ? event.label : ""));
    pen.textAlign = "center";
    pen.fillText(clock, width - 5 * unit, height - 1.8 * unit);
    pen.font = "bold " + Math.round(1.3 * unit) + "px sans-serif";
    if (data.anchors.length) said.forEach((text, k) => pen.fillText(text, ...place(data.anchors[k], width, height)));
    else pen.fillText(said.filter(Boolean).join("   "), width / 2, 1.8 * unit);
    return canvas;
  }

  fit_window();
  set_speed(data.speed);
  seek(0);
  tick();
  return { play, pause, seek, set_speed, picture, fit, duration, time: () => animator.time };
})();
"""

START = """
if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) playback.play();
"""
