// The scene of the page: items whose places are columns of the tables, drawn with three.js, z up, in the units of the
// tables. docs/viewer.md describes the items.

function make_world() {
  const plane = { xz: true, xy: true, yz: true }[scene_data.view] ? scene_data.view : null;  // flat scenes
  const view = document.createElement("div"), legend = document.createElement("div");
  view.id = "view";
  legend.id = "legend";
  view.append(legend);
  document.querySelector("main").prepend(view);
  const none = { show() {}, look_from() {}, resize() {}, picture: () => "", trace() {}, sun: {}, named: {} };
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true });
  } catch (error) {
    legend.textContent = "The scene needs WebGL, which this browser does not support.";
    return none;
  }
  view.append(renderer.domElement);
  THREE.Object3D.DefaultUp.set(0, 0, 1);
  const world = new THREE.Scene();
  world.background = new THREE.Color(0xf4f6f8);
  world.add(new THREE.HemisphereLight(0xffffff, 0x99a0a6, 0.75));
  const sun = new THREE.DirectionalLight(0xffffff, 0.55);
  world.add(sun, sun.target);

  // ---- Values: a number, a column ("height", "-height", "feet:height"), or { column, times, plus } ----
  const run = runs[0];
  function value(entry, item) {
    if (typeof entry === "number") return () => entry;
    if (typeof entry === "object") {
      const inner = value(entry.column, item), { times = 1, plus = 0 } = entry;
      return t => times * inner(t) + plus;
    }
    const sign = entry[0] === "-" ? -1 : 1, parts = entry.replace(/^-/, "").split(":");
    const name = parts.pop(), table = parts.pop() || item.table || scene_data.table || "trajectory";
    return t => sign * runs[0].tables[table].at(name, t);
  }
  const where = object => new THREE.Vector3().setFromMatrixPosition(object.matrixWorld);
  const values = (entries, item) => {
    const each = entries.map(entry => value(entry, item));
    return t => each.map(f => f(t));
  };

  // ---- Items: a group for the place, and in it the shape -------------------------------------------
  const named = {}, updates = [], trails = [], moving = [];
  const material = item => new THREE.MeshLambertMaterial({
    color: item.color || "#b0bec5", transparent: item.opacity < 1, opacity: item.opacity ?? 1, side: THREE.DoubleSide });
  const on_top = item => new THREE.MeshBasicMaterial({ color: item.color || "#1565c0", depthTest: false, transparent: true,
                                                       opacity: item.opacity ?? 1 });
  const solid = geometry => item => Object.assign(new THREE.Mesh(geometry(item), material(item)), { castShadow: true });
  const upright = (radius, height) => new THREE.CylinderGeometry(radius, radius, height, 32).rotateX(Math.PI / 2);
  const shapes = {
    frame: () => new THREE.Group(),
    point: item => Object.assign(new THREE.Mesh(new THREE.SphereGeometry((item.size || 0.04) / 2, 24, 16), on_top(item)),
                                 { renderOrder: 3 }),
    sphere: solid(item => new THREE.SphereGeometry(item.size / 2, 64, 40)),
    box: solid(item => new THREE.BoxGeometry(...item.size)),
    cylinder: solid(item => upright(item.size[0] / 2, item.size[1])),
    line: make_line, polygon: make_polygon, arrow: make_arrow, path: make_path, robot: make_robot,
  };

  // A tube or, without a width, a line of one pixel through points, which may move: places, or names of items.
  function make_line(item) {
    const group = new THREE.Group();
    const places = item.points.map(point => {
      if (typeof point === "string")
        return () => { named[point].updateWorldMatrix(true, false); return group.worldToLocal(where(named[point])); };
      const place = values(point, item);
      return t => new THREE.Vector3(...place(t));
    });
    const corners = t => places.map(place => place(t));
    if (item.width) {
      const bars = corners(begin).slice(1).map(() => {
        const bar = new THREE.Mesh(new THREE.CylinderGeometry(item.width / 2, item.width / 2, 1, 16), material(item));
        group.add(bar);
        return bar;
      });
      updates.push(t => {
        const points = corners(t);
        bars.forEach((bar, i) => {
          const along = points[i + 1].clone().sub(points[i]), length = along.length();
          bar.position.copy(points[i]).addScaledVector(along, 0.5);
          bar.scale.y = Math.max(length, 1e-9);
          if (length > 0) bar.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length));
        });
      });
    } else {
      const line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: item.color || "#546e7a" }));
      line.frustumCulled = false;
      group.add(line);
      updates.push(t => line.geometry.setFromPoints(corners(t)));
    }
    return group;
  }

  // A filled polygon that stands still, in the plane of its group.
  function make_polygon(item) {
    const group = new THREE.Group();
    const fill = new THREE.Mesh(
      new THREE.ShapeGeometry(new THREE.Shape(item.points.map(c => new THREE.Vector2(c[0], c[1])))),
      new THREE.MeshBasicMaterial({ color: item.color || "#a5d6a7", transparent: true, opacity: item.opacity ?? 0.6,
                                    side: THREE.DoubleSide }));
    const edge = new THREE.LineLoop(
      new THREE.BufferGeometry().setFromPoints(item.points.map(c => new THREE.Vector3(c[0], c[1], 0))),
      new THREE.LineBasicMaterial({ color: item.edge || "#388e3c", depthTest: false }));
    edge.renderOrder = 1;
    group.add(fill, edge);
    return group;
  }

  // `vector` times `scale`; with `ends` the tip is at the place of the item.
  function make_arrow(item) {
    const group = new THREE.Group(), radius = item.width ? item.width / 2 : 0.008;
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1, 16), on_top(item));
    const tip = new THREE.Mesh(new THREE.ConeGeometry(2.6 * radius, 1, 20), on_top(item));
    group.add(shaft, tip);
    shaft.renderOrder = tip.renderOrder = 2;
    const vector = values(item.vector, item);
    updates.push(t => {
      const along = new THREE.Vector3(...vector(t)).multiplyScalar(item.scale ?? 1), length = along.length();
      group.visible = length > 0.5 * radius;
      if (!group.visible) return;
      const head = Math.min(6.5 * radius, 0.5 * length), from = item.ends ? -length : 0;
      along.divideScalar(length);
      if (item.world) {  // the vector has the axes of the world, its place those of a moving item
        const turned = new THREE.Quaternion();
        group.parent.getWorldQuaternion(turned);
        along.applyQuaternion(turned.conjugate());
      }
      group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along);
      shaft.scale.y = length - head;
      shaft.position.y = from + (length - head) / 2;
      tip.scale.y = head;
      tip.position.y = from + length - head / 2;
    });
    return group;
  }

  // The way of another item over the whole run; `at` with null: that coordinate is kept.
  function make_path(item) {
    const line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: item.color || "#1565c0" }));
    line.frustumCulled = false;
    trails.push({ item, line });
    return line;
  }

  // A robot from robot.json: a frame per joint, and in it the link that the joint turns.
  function make_robot(item) {
    const robot = item.robot, group = new THREE.Group(), table = item.table || "trajectory";
    const place = (object, data) => {
      object.position.set(...data.position);
      object.quaternion.set(data.rotation[1], data.rotation[2], data.rotation[3], data.rotation[0]);
      return object;
    };
    const geometries = unpack_meshes(item.meshes || [], item.packed || "");
    const grey = new THREE.MeshPhongMaterial({ color: 0xb0bec5, flatShading: true, shininess: 8 });
    const add = (parent, geometry, look, data) => {
      const mesh = place(new THREE.Mesh(geometry, look), data);
      mesh.castShadow = true;
      parent.add(mesh);
    };
    const links = robot.bodies.map(body => {
      const frame = place(new THREE.Group(), body), link = new THREE.Group();
      frame.add(link);
      named[`${item.name}.${body.name}`] = link;
      return { body, frame, link, axis: new THREE.Vector3(...body.axis).normalize() };
    });
    links.forEach(l => (l.body.parent < 0 ? group : links[l.body.parent].link).add(l.frame));
    for (const { body, link, frame } of links) {
      for (const look of body.looks) {
        for (const visual of look.visuals) {
          const [a, , c] = visual.size;
          const geometry = visual.shape === "mesh" ? geometries[visual.index]
            : visual.shape === "box" ? new THREE.BoxGeometry(...visual.size)
            : visual.shape === "sphere" ? new THREE.SphereGeometry(a / 2, 32, 20) : upright(a / 2, c);
          add(link, geometry, new THREE.MeshPhongMaterial({
            color: new THREE.Color(...visual.colour).multiplyScalar(0.85), flatShading: true, shininess: 12,
            side: THREE.DoubleSide }), visual);
        }
        if (look.visuals.length === 0) for (const box of look.boxes) add(link, new THREE.BoxGeometry(...box.size), grey, box);
      }
      if (body.looks.length > 0) continue;
      for (const box of body.boxes) add(link, new THREE.BoxGeometry(...box.size), grey, box);
      const to = frame.position, length = to.length();  // a bar from the parent's joint to this one
      if (body.parent < 0 || length < 0.03) continue;
      const bar = new THREE.Mesh(new THREE.CylinderGeometry(0.025, 0.025, length, 16), grey);
      bar.position.copy(to).multiplyScalar(0.5);
      bar.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), to.clone().normalize());
      links[body.parent].link.add(bar);
    }
    for (const side of ["left_sole", "right_sole"]) {
      if (!robot[side]) continue;
      named[`${item.name}.${side}`] = place(new THREE.Group(), robot[side]);
      links[robot[side].body].link.add(named[`${item.name}.${side}`]);
    }
    const base = values(["x", "y", "z", "qx", "qy", "qz", "qw"].map(e => "base_" + e), item);
    const joints = links.filter(l => l.body.joint).map(l => [l, value("q_" + l.body.joint, item)]);
    updates.push(t => {
      const [x, y, z, ...turn] = base(t);
      links[0].frame.position.set(x, y, z);
      links[0].frame.quaternion.set(...turn).normalize();
      for (const [l, angle] of joints) l.link.quaternion.setFromAxisAngle(l.axis, angle(t));
    });
    return group;
  }

  // Corners with 16 bits per coordinate within the box of their mesh (walking/replay_meshes.py).
  function unpack_meshes(meshes, packed) {
    const buffer = bytes(packed);
    return meshes.map(m => {
      const raw = new Uint16Array(buffer, m.offset, 3 * (m.corners + m.triangles));
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(
        Float32Array.from(raw.subarray(0, 3 * m.corners), (level, i) => m.low[i % 3] + m.step[i % 3] * level), 3));
      geometry.setIndex(new THREE.BufferAttribute(raw.slice(3 * m.corners), 1));
      return geometry;
    });
  }

  // Applies `at`, then `turn` about an axis, `rpy` (yaw, then pitch, then roll) or a quaternion (w, x, y, z).
  function place_item(item, group) {
    const at = item.at && values(item.at, item), rpy = item.rpy && values(item.rpy, item);
    const quaternion = item.quaternion && values(item.quaternion, item);
    const angle = item.angle !== undefined && value(item.angle, item);
    const axis = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] }[item.axis || "y"];
    const constant = entries => !entries || entries.flat().every(e => typeof e === "number");
    const is_moving = !constant(item.at) || rpy || quaternion || angle || !constant(item.points) || item.shape === "robot";
    if (is_moving) moving.push(group);
    return t => {
      const place = at ? at(t) : [0, 0, 0];
      group.visible = place.every(Number.isFinite) && t >= (item.from ?? -Infinity) - 1e-6 && t < (item.until ?? Infinity) - 1e-6;
      if (!group.visible) return;
      group.position.set(...place);
      if (quaternion) { const [w, x, y, z] = quaternion(t); group.quaternion.set(x, y, z, w).normalize(); }
      if (rpy) group.quaternion.setFromEuler(new THREE.Euler(...rpy(t), "ZYX"));
      if (angle) group.quaternion.setFromAxisAngle(new THREE.Vector3(...axis), angle(t));
    };
  }

  for (const item of scene_data.items) {
    const group = new THREE.Group(), first = updates.length;
    if (item.name) named[item.name] = group;
    group.add(shapes[item.shape || "frame"](item));
    const inner = updates.splice(first), outer = place_item(item, group);
    updates.push(t => { outer(t); if (group.visible) for (const update of inner) update(t); });
    (item.on ? named[item.on] : world).add(group);
    if (item.legend) {
      const line = element("div", legend), mark = element("i", line);
      mark.style.background = item.color || "#b0bec5";
      line.append(item.legend);
    }
  }
  const note = element("div", legend);
  note.id = "note";
  function pose(t) {
    for (const update of updates) update(t);
    world.updateMatrixWorld(true);
  }

  // ---- What the camera sees: the moving items over the run, or those at the start of what it follows ----
  const target = scene_data.follow && named[scene_data.follow];
  const box = new THREE.Box3(), samples = target ? 1 : 60;
  const seen = moving.length > 0 ? moving : [world];
  for (let i = 0; i < samples; ++i) {
    pose(begin + (end - begin) * i / Math.max(1, samples - 1));
    for (const object of seen) if (object.visible) box.expandByObject(object);
  }
  if (box.isEmpty()) box.setFromCenterAndSize(new THREE.Vector3(), new THREE.Vector3(1, 1, 1));
  const centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
  const radius = Math.max(size.length() / 2, 1e-6);

  // Paths of items, from the places that they pass in the whole run.
  const count = trails.length > 0 ? 800 : 0;
  function trace() {
    const points = trails.map(() => []);
    for (let i = 0; i <= count; ++i) {
      pose(begin + (end - begin) * i / (count || 1));
      trails.forEach(({ item }, k) => {
        const point = where(named[item.of]);
        if (item.height !== undefined) point.z = item.height;
        points[k].push(point);
      });
    }
    trails.forEach(({ line }, k) => line.geometry.setFromPoints(points[k]));
  }
  updates.push(t => trails.forEach(({ line }) =>
    line.geometry.setDrawRange(0, 1 + Math.round(count * (t - begin) / (end - begin || 1)))));
  trace();
  pose(begin);

  if (scene_data.ground) {
    const cell = 10 ** Math.floor(Math.log10(radius)), cells = 40;
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(10 * cells * cell, 10 * cells * cell), new THREE.MeshLambertMaterial({ color: 0xc6cdd2 }));
    floor.position.z = -0.003 * radius;
    floor.receiveShadow = true;
    const grid = new THREE.Group();  // a tenth of the size, and ten times as much
    grid.add(new THREE.GridHelper(cells * cell, cells, 0xcfd8dc, 0xcfd8dc), new THREE.GridHelper(cells * cell, cells / 10, 0x90a4ae, 0x90a4ae));
    grid.rotation.x = Math.PI / 2;
    world.grid = { floor, grid, cell: 10 * cell };
    world.add(floor, grid);
    if (scene_data.ground === "grid") floor.visible = false;
    sun.castShadow = renderer.shadowMap.enabled = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -2 * radius, right: 2 * radius, top: 2 * radius, bottom: -2 * radius,
                                       near: 0.1 * radius, far: 12 * radius });
  }
  sun.position.copy(centre).add(new THREE.Vector3(1.5, -1.0, 3.0).multiplyScalar(1.5 * radius));
  sun.target.position.copy(centre);

  // ---- Camera --------------------------------------------------------------------------------------
  const camera = plane ? new THREE.OrthographicCamera(-1, 1, 1, -1, -100 * radius, 100 * radius)
                       : new THREE.PerspectiveCamera(35, 1, 0.01 * radius, 100 * radius);
  const orbit = new THREE.OrbitControls(camera, renderer.domElement);
  orbit.enableRotate = !plane;
  if (scene_data.ground) orbit.maxPolarAngle = 0.49 * Math.PI;  // the floor is only visible from above
  const ways = { oblique: [2.0, -1.1, 0.6], front: [1, 0, 0.1], side: [0, -1, 0.1], top: [-0.001, 0, 1],
                 xz: [0, -1, 0], xy: [0, 0, 1], yz: [1, 0, 0] };
  const start = target && where(target), leash = 0.3 * radius, moved = new THREE.Vector3();
  function look_from(name) {
    if (!ways[name]) return;
    if (select) select.value = name;
    if (name === "xy") camera.up.set(0, 1, 0);
    camera.position.set(...ways[name]).setLength(3.6 * radius).add(centre).add(moved);
    orbit.target.copy(centre).add(moved);
    orbit.update();
  }
  // The view follows a walking robot, but not a swaying one. The grid follows in whole cells.
  function follow() {
    const ahead = where(target).sub(start).sub(moved);
    if (!plane) ahead.z = 0;
    const step = ahead.setLength(Math.max(0, ahead.length() - leash));
    moved.add(step);
    for (const object of [camera, sun, sun.target, world.grid && world.grid.floor]) if (object) object.position.add(step);
    orbit.target.add(step);
    if (world.grid)
      world.grid.grid.position.set(...["x", "y"].map(e => Math.round((centre[e] + moved[e]) / world.grid.cell) * world.grid.cell), 0);
  }
  let select = null;
  if (!plane) {
    select = document.createElement("select");
    for (const name of ["oblique", "front", "side", "top"]) element("option", select, name);
    select.onchange = () => { look_from(select.value); draw(); };
    const label = element("label", document.getElementById("bar"), "view ");
    label.append(select);
  }
  const draw = () => renderer.render(world, camera);
  orbit.addEventListener("change", () => { if (!playing) draw(); });
  look_from(plane || scene_data.view && ways[scene_data.view] && scene_data.view || "oblique");

  const note_lasts = 1.5;  // s
  return {
    look_from, camera, named, sun, trace, renderer,
    show(t) {
      pose(t);
      if (target) follow();
      const said = (scene_data.notes || []).filter(([from]) => from < t + 1e-6 && t - from < note_lasts);
      note.textContent = said.length > 0 ? said[said.length - 1][1] : "";
      draw();
    },
    resize() {
      const [width, height] = [view.clientWidth, view.clientHeight];
      renderer.setPixelRatio(devicePixelRatio);
      renderer.setSize(width, height);
      if (plane) {
        const [across, up] = [size[plane[0]], size[plane[1]]];
        const half = 0.62 * Math.max(up, across * height / width, 1e-6);
        Object.assign(camera, { top: half, bottom: -half, left: -half * width / height, right: half * width / height });
      } else {
        camera.aspect = width / height;
        camera.fov = width > height ? 35 : 2 * Math.atan(Math.tan(35 * Math.PI / 360) * height / width) * 180 / Math.PI;
      }
      camera.updateProjectionMatrix();
      draw();
    },
    // The picture that show() has just drawn.
    picture: () => renderer.domElement.toDataURL("image/jpeg", 0.92).split(",")[1],
  };
}
