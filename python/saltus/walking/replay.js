// The program of the replay page: builds the robot from its joints, sets its pose at any time, and
// draws the forces on it. The page defines robot, meshes, packed_meshes, scene_data, motion and
// packed.
"use strict";

// ---- Motion: channel by channel, low + step * level -------------------------------------------
const bytes = Uint8Array.from(atob(packed), c => c.charCodeAt(0));
const levels = new DataView(bytes.buffer);
const channel = {};
motion.channels.forEach(([name, low, step], index) => { channel[name] = { index, low, step }; });

function at_frame(name, frame) {
  const c = channel[name];
  return c.low + c.step * levels.getUint16(2 * (c.index * motion.frames + frame), true);
}
// Linear interpolation between frames for smooth slow motion.
function value(name, position) {
  const frame = Math.min(Math.floor(position), motion.frames - 1);
  const next = Math.min(frame + 1, motion.frames - 1);
  const fraction = position - frame;
  return (1 - fraction) * at_frame(name, frame) + fraction * at_frame(name, next);
}
const vector = (prefix, position) =>
  new THREE.Vector3(...["x", "y", "z"].map(e => value(prefix + e, position)));

// ---- World: z up, x forward, metres -----------------------------------------------------------
THREE.Object3D.DefaultUp.set(0, 0, 1);
const view = document.getElementById("view");
let renderer;
try {
  renderer = new THREE.WebGLRenderer({ antialias: true });
} catch (error) {
  view.textContent = "The replay needs WebGL, which this browser does not support.";
  throw error;
}
view.appendChild(renderer.domElement);
const world = new THREE.Scene();
world.background = new THREE.Color(0xf4f6f8);
const camera = new THREE.PerspectiveCamera(35, 1, 0.05, 50);
const orbit = new THREE.OrbitControls(camera, renderer.domElement);
orbit.maxPolarAngle = 0.49 * Math.PI;  // the floor is only visible from above
const size = at_frame("com_z", 0) / 0.56;  // relative to iCub
const centre = new THREE.Vector3(0, -0.1, 0.42).multiplyScalar(size);
const cameras = { oblique: [2.1, -1.1, 0.95], front: [2.5, -0.1, 0.55], side: [0.0, -2.6, 0.55],
                  top: [-0.01, -0.1, 2.6] };
const moved = new THREE.Vector3();  // how far the scene has followed the robot
function look_from(name) {
  camera.position.set(...cameras[name]).multiplyScalar(size).add(moved);
  orbit.target.copy(centre).add(moved);
  orbit.update();
}

world.add(new THREE.HemisphereLight(0xffffff, 0x99a0a6, 0.75));
const sun = new THREE.DirectionalLight(0xffffff, 0.55);
sun.position.set(1.5, -1.0, 3.0).multiplyScalar(size);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
Object.assign(sun.shadow.camera, { left: -1.2 * size, right: 1.2 * size,
                                  top: 1.2 * size, bottom: -1.2 * size });
world.add(sun, sun.target);
renderer.shadowMap.enabled = true;

const ground = new THREE.Mesh(new THREE.PlaneGeometry(8, 8),
                              new THREE.MeshLambertMaterial({ color: 0xe3e7ea }));
ground.position.z = -0.002;
ground.receiveShadow = true;
world.add(ground);
const grid = new THREE.Group();  // squares of 0.1 m and of 1 m
grid.add(new THREE.GridHelper(4, 40, 0xcfd8dc, 0xcfd8dc), new THREE.GridHelper(4, 4, 0x90a4ae, 0x90a4ae));
grid.rotation.x = Math.PI / 2;
world.add(grid);

// The view follows a walking robot, but not a swaying one. The grid follows in whole metres.
const start = vector("com_", 0), leash = 0.3 * size;
function follow(com) {
  const ahead = com.clone().sub(start).sub(moved).setZ(0);
  const step = ahead.setLength(Math.max(0, ahead.length() - leash));
  moved.add(step);
  for (const object of [camera, sun, sun.target, ground]) object.position.add(step);
  orbit.target.add(step);
  grid.position.set(Math.round(moved.x), Math.round(moved.y), 0);
}

// Polygons on the ground, slightly above it.
function polygon(corners, color, height, opacity) {
  const group = new THREE.Group();
  if (corners) {
    const fill = new THREE.Mesh(
      new THREE.ShapeGeometry(new THREE.Shape(corners.map(c => new THREE.Vector2(...c)))),
      new THREE.MeshBasicMaterial({ color, transparent: true, opacity }));
    const edge = new THREE.LineLoop(
      new THREE.BufferGeometry().setFromPoints(corners.map(c => new THREE.Vector3(...c, 0))),
      new THREE.LineBasicMaterial({ color: 0x388e3c, depthTest: false }));
    edge.renderOrder = 1;  // visible through the feet
    group.add(fill, edge);
  }
  group.position.z = height;
  world.add(group);
  return group;
}
// The supports, one record after the other.
const grounds = scene_data.ground.map(record => polygon(record.corners, 0xa5d6a7, 0.003, 0.6));

// ---- Robot: a frame per joint, and in it the link that the joint turns ------------------------
const light_grey = new THREE.MeshLambertMaterial({ color: 0xdfe3e8 });
const dark_grey = new THREE.MeshLambertMaterial({ color: 0x546e7a });
const density = 1400;  // kg/m^3, for the thickness of a link

function add_mesh(parent, geometry, material) {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = true;
  parent.add(mesh);
  return mesh;
}
const ball = (parent, place, radius, material) =>
  add_mesh(parent, new THREE.SphereGeometry(radius, 24, 16), material).position.copy(place);

function capsule(parent, from, to, radius, material) {
  const along = to.clone().sub(from);
  const tube = add_mesh(parent, new THREE.CylinderGeometry(radius, radius, along.length(), 24),
                        material);
  tube.position.copy(from).addScaledVector(along, 0.5);
  tube.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.clone().normalize());
  ball(parent, from, radius, material);
  ball(parent, to, radius, material);
}

const xyz = list => new THREE.Vector3(...list);
const rotation = q => new THREE.Quaternion(q[1], q[2], q[3], q[0]);
const links = robot.bodies.map(body => {
  const frame = new THREE.Group(), link = new THREE.Group();  // the joint, and the link that it moves
  frame.position.copy(xyz(body.position));
  frame.quaternion.copy(rotation(body.rotation));
  frame.add(link);
  return { body, frame, link, axis: xyz(body.axis).normalize(), children: [] };
});
links.forEach((l, i) => {
  (l.body.parent < 0 ? world : links[l.body.parent].link).add(l.frame);
  if (l.body.parent >= 0) links[l.body.parent].children.push(i);
});

function pose(position) {
  const base = links[0].frame;
  base.position.copy(vector("base_", position));
  base.quaternion.copy(rotation(["w", "x", "y", "z"].map(e => value("base_q" + e, position))));
  base.quaternion.normalize();
  for (const l of links)
    if (l.body.joint)
      l.link.quaternion.setFromAxisAngle(l.axis, value("q_" + l.body.joint, position));
  world.updateMatrixWorld(true);
}

// ---- Shapes of the URDF, boxes where a link's meshes are missing ------------------------------
const mesh_bytes = Uint8Array.from(atob(packed_meshes), c => c.charCodeAt(0));
const geometries = meshes.map(m => {
  const raw = new DataView(mesh_bytes.buffer, m.offset), at = i => raw.getUint16(2 * i, true);
  const corners = new Float32Array(3 * m.corners), index = new Uint16Array(3 * m.triangles);
  for (let i = 0; i < corners.length; ++i) corners[i] = m.low[i % 3] + m.step[i % 3] * at(i);
  for (let i = 0; i < index.length; ++i) index[i] = at(corners.length + i);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
});
function geometry_of(visual) {
  const size = visual.size;
  if (visual.shape === "mesh") return geometries[visual.index];
  if (visual.shape === "box") return new THREE.BoxGeometry(...size);
  if (visual.shape === "sphere") return new THREE.SphereGeometry(size[0] / 2, 32, 20);
  return new THREE.CylinderGeometry(size[0] / 2, size[0] / 2, size[2], 32).rotateX(Math.PI / 2);
}
const box_grey = new THREE.MeshPhongMaterial({ color: 0xb0bec5, flatShading: true, shininess: 8 });
function place(parent, geometry, material, data) {
  const mesh = add_mesh(parent, geometry, material);
  mesh.position.copy(xyz(data.position));
  mesh.quaternion.copy(rotation(data.rotation));
  return mesh;
}
// Ground that is not level. The first box is the level part under the stance foot.
if (scene_data.ground_boxes) {
  const slabs = new THREE.Group();
  slabs.position.z = ground.position.z;
  world.add(slabs);
  ground.visible = false;
  scene_data.ground_boxes.forEach((box, index) => {
    const color = index === 0 ? 0xe3e7ea : box.soft ? 0xbcaaa4 : 0xb0bec5;
    const material = new THREE.MeshLambertMaterial({ color });
    const mesh = place(slabs, new THREE.BoxGeometry(...box.size), material, box);
    mesh.castShadow = false;
    mesh.receiveShadow = true;
  });
}
const has_looks = links.some(l => l.body.looks.length > 0);
function draw_looks(l) {
  for (const look of l.body.looks) {
    for (const visual of look.visuals)
      place(l.link, geometry_of(visual), new THREE.MeshPhongMaterial({
        color: new THREE.Color(...visual.colour).multiplyScalar(0.85), flatShading: true, shininess: 12,
        side: THREE.DoubleSide }), visual);
    if (look.visuals.length === 0)
      for (const box of look.boxes) place(l.link, new THREE.BoxGeometry(...box.size), box_grey, box);
  }
}

// ---- Links without shapes: schematic bodies from joint distances and masses -------------------
const short = 0.03;  // m: nearer joints look like one joint
// The mass of bodies that coincide at one point belongs to the last of them.
function thickness(index, length) {
  let mass = links[index].body.mass / Math.max(1, links[index].children.length);
  for (let i = index; links[i].body.parent > 0 && links[i].frame.position.length() < short;) {
    i = links[i].body.parent;
    mass += links[i].body.mass;
  }
  const radius = Math.sqrt(mass / (density * Math.PI * length));
  return Math.min(Math.max(radius, 0.02), 0.055, 0.45 * length);
}
const sole_frames = ["left_sole", "right_sole"].map(name => {
  const data = robot[name], frame = new THREE.Group();
  frame.position.copy(xyz(data.position));
  frame.quaternion.copy(rotation(data.rotation));
  links[data.body].link.add(frame);
  if (has_looks) return frame;
  const height = 0.02, x = data.foot_x, y = data.foot_y;
  const plate = add_mesh(frame, new THREE.BoxGeometry(x[1] - x[0], y[1] - y[0], height), dark_grey);
  plate.position.set((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, height / 2);
  return frame;
});
// The trunk: the highest body above the base that carries several limbs. The bodies between base
// and trunk are drawn as one spine.
pose(0);
const height_of = l => new THREE.Vector3().setFromMatrixPosition(l.link.matrixWorld).z;
const trunk = links.slice(1)
  .filter(l => l.children.length > 1 && height_of(l) > height_of(links[0]))
  .sort((a, b) => height_of(b) - height_of(a))[0];
const spine = [];
for (let l = trunk; l && l.body.parent >= 0; l = links[l.body.parent]) spine.unshift(l);

// Bars from the middle of the limbs to each of them, one to `end`, all in the link's frame.
function draw_hub(l, end, bar, stem) {
  const places = l.children.map(c => links[c]).filter(limb => !spine.includes(limb))
    .map(limb => limb.frame.position);
  const middle = places.reduce((sum, p) => sum.add(p), new THREE.Vector3())
    .divideScalar(Math.max(1, places.length));
  for (const place of places) capsule(l.link, middle, place, bar, light_grey);
  if (end) capsule(l.link, middle, end, stem, light_grey);
  return middle;
}

// A head that shows the heading of the robot; the model's head is frozen to the trunk. World axes
// at the start: x forward.
function draw_head(neck) {
  const head = new THREE.Group();
  head.position.copy(neck);
  head.quaternion.setFromRotationMatrix(trunk.link.matrixWorld).conjugate();
  trunk.link.add(head);
  capsule(head, new THREE.Vector3(0, 0, 0), new THREE.Vector3(0, 0, 0.08), 0.025, dark_grey);
  ball(head, new THREE.Vector3(0, 0, 0.15), 0.075, light_grey);
  for (const side of [-1, 1])
    ball(head, new THREE.Vector3(0.065, 0.028 * side, 0.165), 0.016, dark_grey);
}

function draw_link(l, i) {
  const origin = new THREE.Vector3();
  for (const c of l.children) {
    const to = links[c].frame.position;
    if (to.length() > short) capsule(l.link, origin, to, thickness(i, to.length()), light_grey);
    ball(l.link, to, 0.028, dark_grey);
  }
  const sole = sole_frames.find(s => s.parent === l.link);
  if (sole) return capsule(l.link, origin, sole.position.clone().multiplyScalar(0.75), 0.025,
                           light_grey);
  // The CoM of a rod is halfway to its end.
  if (l.children.length === 0) {
    const end = xyz(l.body.com).multiplyScalar(2);
    if (end.length() > short) capsule(l.link, origin, end, thickness(i, end.length()), light_grey);
  }
  for (const box of l.body.boxes) {
    const mesh = add_mesh(l.link, new THREE.BoxGeometry(...box.size), light_grey);
    mesh.position.copy(xyz(box.position));
    mesh.quaternion.copy(rotation(box.rotation));
  }
}

links.forEach((l, i) => {
  if (has_looks) {
    draw_looks(l);
  } else if (trunk && i === 0) {
    draw_hub(l, spine[0].frame.position, 0.045, 0.06);
  } else if (l === trunk) {
    const waist = new THREE.Vector3().setFromMatrixPosition(spine[0].frame.matrixWorld);
    draw_head(draw_hub(l, l.link.worldToLocal(waist), 0.042, 0.066));
  } else if (!spine.includes(l)) {
    draw_link(l, i);
  }
});

// ---- Forces, feet and points ------------------------------------------------------------------
// Arrows are drawn in front of the robot.
function make_arrow(color, radius) {
  const group = new THREE.Group();
  const material = new THREE.MeshBasicMaterial({ color, transparent: true, opacity: 0.9,
                                                 depthTest: false });
  const shaft = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1, 16), material);
  const tip = new THREE.Mesh(new THREE.ConeGeometry(2.6 * radius, 1, 20), material);
  group.add(shaft, tip);
  group.renderOrder = shaft.renderOrder = tip.renderOrder = 2;
  world.add(group);
  return (from, along) => {
    const length = along.length(), head = Math.min(0.05, 0.5 * length);
    group.visible = length > 0.005;
    if (!group.visible) return;
    group.position.copy(from);
    group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.clone().normalize());
    shaft.scale.y = length - head;
    shaft.position.y = (length - head) / 2;
    tip.scale.y = head;
    tip.position.y = length - head / 2;
  };
}
const metres_per_newton = 0.0012, push_metres_per_newton = 0.004;
const foot_arrows = [make_arrow(0x2e7d32, 0.008), make_arrow(0x2e7d32, 0.008)];
const push_arrow = make_arrow(0xd32f2f, 0.011);

function marker(color, radius) {
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 24, 16), new THREE.MeshBasicMaterial(
    { color, depthTest: false, transparent: true }));
  mesh.renderOrder = 3;
  world.add(mesh);
  return mesh;
}
const com_mark = marker(0x1565c0, 0.022), icp_mark = marker(0xef6c00, 0.016);
const plumb = new THREE.Line(
  new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, -1)]),
  new THREE.LineBasicMaterial({ color: 0x1565c0 }));
world.add(plumb);

function trail(color, point) {
  const points = [];
  for (let i = 0; i < motion.frames; ++i) points.push(point(i));
  const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
                              new THREE.LineBasicMaterial({ color }));
  line.frustumCulled = false;
  world.add(line);
  return line;
}
const com_trail = trail(0x1565c0, i => vector("com_", i).setZ(0.005));
const icp_trail =
  trail(0xef6c00, i => new THREE.Vector3(value("icp_x", i), value("icp_y", i), 0.006));

// Positions considered by the planner of steps (small), and the chosen one.
function place_mark(radius, color) {
  const disc = new THREE.Mesh(new THREE.CircleGeometry(radius, 24),
                              new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true,
                                                            opacity: 0.8 }));
  disc.renderOrder = 2;
  disc.visible = false;
  world.add(disc);
  return disc;
}
const plans = scene_data.plans || [];
const most_places = plans.reduce((most, plan) => Math.max(most, plan[2].length), 0);
const considered_marks = Array.from({ length: most_places }, () => place_mark(0.008, 0x7b1fa2));
const chosen_mark = place_mark(0.018, 0x7b1fa2);
const plan_lasts = 0.015;  // s: a tick and a half

// Returns a description.
function show_plan(time) {
  let last = plans.length - 1;
  while (last >= 0 && plans[last][0] > time + 1e-6) --last;
  const [from, chosen, places] = last >= 0 && time - plans[last][0] < plan_lasts ? plans[last]
                                                                                 : [0, null, []];
  considered_marks.forEach((mark, i) => {
    mark.visible = i < places.length;
    if (mark.visible) mark.position.set(places[i][0], places[i][1], 0.007);
  });
  chosen_mark.visible = chosen !== null;
  if (chosen === null) return places.length > 0 ? "\nno step" : "";
  chosen_mark.position.set(chosen[1], chosen[2], 0.008);
  const left = Math.max(0, chosen[3] - time);
  return `\n${chosen[0] > 0.5 ? "right" : "left"} foot lands in ${left.toFixed(2)} s`;
}

// A violated requirement is shown until the next one, or for this time (s).
const unmet_lasts = 1.5;
const unmet_text = document.getElementById("unmet");
function show_unmet(time) {
  const told = (scene_data.unmet || []).filter(([t]) => t < time + 1e-6 && time - t < unmet_lasts);
  unmet_text.textContent = told.length > 0 ? told[told.length - 1][1] : "";
}

function draw_force(arrow, side, position) {
  const foot = side === 0 ? "left" : "right", name = e => value(`${foot}_filtered_${e}`, position);
  const force = new THREE.Vector3(name("fx"), name("fy"), name("fz"));
  const loaded = force.z > 5;  // N: below this the centre of pressure is meaningless
  const place = loaded ? new THREE.Vector3(-name("ty") / force.z, name("tx") / force.z, 0)
                       : new THREE.Vector3();
  const sole = sole_frames[side];
  const turned = force.clone().transformDirection(sole.matrixWorld).setLength(
    loaded ? force.length() * metres_per_newton : 0);
  arrow(sole.localToWorld(place), turned);
  return force.z;
}

const figures = document.getElementById("figures");
const newtons = f => String(Math.round(f)).padStart(4, "\u2007") + " N";  // figure spaces
function show(position) {
  pose(position);
  const standing = scene_data.ground.findLastIndex(
    record => record.from_s < time_of(position) + 1e-6);
  grounds.forEach((group, index) => { group.visible = index === standing; });
  const { left, right } = scene_data.ground[standing];
  const com = vector("com_", position);
  follow(com);
  com_mark.position.copy(com);
  plumb.position.copy(com);
  plumb.scale.z = com.z;
  icp_mark.position.set(value("icp_x", position), value("icp_y", position), 0.006);
  const frame = Math.floor(position) + 1;
  com_trail.geometry.setDrawRange(0, frame);
  icp_trail.geometry.setDrawRange(0, frame);
  const forces = foot_arrows.map((arrow, side) => draw_force(arrow, side, position));
  const push = vector("push_", Math.floor(position));
  const along = push.clone().multiplyScalar(push_metres_per_newton);
  const pushed = links.find(l => l.body.name === scene_data.push_body) || links[0];
  const place = new THREE.Vector3(...(scene_data.push_point || [0, 0, 0]));
  place.applyMatrix4(pushed.link.matrixWorld);
  push_arrow(place.sub(along).addScaledVector(along.clone().normalize(), -0.08), along);
  const planned = side => newtons(value(side + "_planned_fz", position));
  figures.textContent =
    `left foot  ${newtons(forces[0])}, planned ${planned("left")}\n` +
    `right foot ${newtons(forces[1])}, planned ${planned("right")}\n` +
    (push.length() > 0.5 ? `push ${push.length().toFixed(0)} N` :
     left && right ? "both feet in contact" : `${left ? "left" : "right"} foot in contact`) +
    show_plan(time_of(position));
  show_unmet(time_of(position));
}

// ---- Time -------------------------------------------------------------------------------------
const play = document.getElementById("play"), scrub = document.getElementById("scrub");
const clock = document.getElementById("clock"), speed = document.getElementById("speed");
scrub.max = motion.frames - 1;
let position = 0, playing = false, last = null;
const time_of = p => motion.start + p / motion.rate;

function refresh() {
  scrub.value = Math.round(position);
  clock.textContent = time_of(position).toFixed(2) + " s";
  play.textContent = playing ? "Pause" : "Play";
  show(position);
  renderer.render(world, camera);
}
function go(p) {
  position = Math.min(Math.max(p, 0), motion.frames - 1);
  refresh();
}
function set_playing(on) {
  if (on && position >= motion.frames - 1) position = 0;
  playing = on;
  last = null;
  refresh();
}
// #t=1.0 pauses the replay at this time; #t=1.0&view=front also selects the view.
function from_address() {
  const wish = new URLSearchParams(location.hash.slice(1));
  if (wish.has("view") && cameras[wish.get("view")]) {
    document.getElementById("camera").value = wish.get("view");
    look_from(wish.get("view"));
  }
  const t = parseFloat(wish.get("t"));
  if (!Number.isFinite(t)) return false;
  playing = false;
  go((t - motion.start) * motion.rate);
  return true;
}
play.onclick = () => set_playing(!playing);
scrub.oninput = () => { playing = false; go(Number(scrub.value)); };
document.getElementById("camera").onchange = e => { look_from(e.target.value); refresh(); };
window.onhashchange = from_address;
window.onkeydown = e => {
  if (e.target.tagName === "SELECT") return;
  if (e.key === " ") set_playing(!playing);
  else if (e.key === "ArrowLeft") { playing = false; go(position - 1); }
  else if (e.key === "ArrowRight") { playing = false; go(position + 1); }
  else return;
  e.preventDefault();
};
function resize() {
  renderer.setPixelRatio(window.devicePixelRatio);
  renderer.setSize(view.clientWidth, view.clientHeight);
  camera.aspect = view.clientWidth / view.clientHeight;
  camera.updateProjectionMatrix();
  refresh();
}
window.onresize = resize;
orbit.addEventListener("change", () => { if (!playing) renderer.render(world, camera); });
// The first frames are slow on slow machines; a running clock would not start at zero.
const longest_gap = 250;  // ms
let drawn = 0;
function tick(now) {
  if (playing) {
    if (last !== null && drawn > 2)
      position += Math.min(now - last, longest_gap) / 1000 * Number(speed.value) * motion.rate;
    last = now;
    ++drawn;
    if (position >= motion.frames - 1) { position = motion.frames - 1; playing = false; }
    refresh();
  }
  requestAnimationFrame(tick);
}
// #movie=20&from=2&to=5 draws 20 pictures per second into the page; saltus movie reads them.
function film(rate, from, to) {
  const frame = t => Math.min(Math.max((t - motion.start) * motion.rate, 0), motion.frames - 1);
  const pictures = [];
  sun.castShadow = false;  // saves half of the time without a graphics card
  for (let p = frame(from); p <= frame(to); p += motion.rate / rate) {
    go(p);
    pictures.push(renderer.domElement.toDataURL("image/jpeg", 0.92).split(",")[1]);
  }
  const text = document.createElement("pre");
  text.id = "film";
  text.textContent = pictures.join("\n");
  document.body.append(text);
}
look_from("oblique");
resize();
const asked = new URLSearchParams(location.hash.slice(1));
const number = (key, otherwise) => asked.has(key) ? parseFloat(asked.get(key)) : otherwise;
if (asked.has("movie")) {
  from_address();
  film(number("movie"), number("from", motion.start), number("to", Infinity));
} else {
  if (!from_address()) set_playing(true);
  requestAnimationFrame(tick);
}
