// A run of an arm in three dimensions, and one mesh of it close up. THREE: the library.
function show(THREE) {
  "use strict";
  var scene = JSON.parse(document.getElementById("scene-data").textContent);
  var at = function (id) { return document.getElementById(id); };
  var numbers = function (text) {
    var raw = atob(text), bytes = new Uint8Array(raw.length);
    for (var i = 0; i < raw.length; i++) { bytes[i] = raw.charCodeAt(i); }
    return new Float32Array(bytes.buffer);
  };
  scene.joints.forEach(function (joint) {
    joint.theta = numbers(joint.theta);
    if (joint.kind === "planetary") {
      joint.sun = numbers(joint.sun);
      joint.planets = joint.planets.map(numbers);
      Object.values(joint.meshes).forEach(function (mesh) {
        mesh.gap = numbers(mesh.gap); mesh.force = numbers(mesh.force);
      });
    }
  });
  var duration = scene.step_s * (scene.frames - 1);
  var state = { time: 0, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches, drawn: 0 };
  var colour = function (name) { return getComputedStyle(document.body).getPropertyValue(name).trim(); };
  var reach = scene.reach;

  // ------------------------------------------------------------------ bodies
  var renderer = null, world = null, camera = null, movers = [], places = [];
  try {
    renderer = new THREE.WebGLRenderer({ canvas: at("arm"), antialias: true, preserveDrawingBuffer: true });
  } catch (error) {
    at("no-webgl").hidden = false;
  }

  function material(name) { return new THREE.MeshLambertMaterial({ color: new THREE.Color(colour(name)) }); }
  function shape(points) { return new THREE.Shape(points.map(function (p) { return new THREE.Vector2(p[0], p[1]); })); }
  function solid(outline, depth, paint) {
    return new THREE.Mesh(new THREE.ExtrudeGeometry(outline, { depth: depth, bevelEnabled: false, curveSegments: 24 }), paint);
  }
  function bar(length, width, depth, paint) {
    var mesh = new THREE.Mesh(new THREE.BoxGeometry(length, width, depth), paint);
    mesh.position.x = length / 2;
    return mesh;
  }
  function gears(joint, frame, link, paint) {
    var face = joint.face_m, rim = new THREE.Shape();
    rim.absarc(0, 0, joint.rim_m, 0, 2 * Math.PI, false);
    rim.holes.push(shape(joint.outlines.ring));
    var ring = solid(rim, face, paint.ring), sun = solid(shape(joint.outlines.sun), face, paint.sun);
    ring.rotation.z = joint.stand.ring;
    frame.add(ring, sun);
    movers.push(function (i) { sun.rotation.z = joint.sun[i]; });
    joint.stand.planets.forEach(function (angle, n) {
      var planet = solid(shape(joint.outlines.planet), face, paint.planet);
      frame.add(planet);
      movers.push(function (i) {
        var where = joint.theta[i] + angle;
        planet.position.set(joint.carrier_m * Math.cos(where), joint.carrier_m * Math.sin(where), 0);
        planet.rotation.z = joint.stand.spins[n] + joint.planets[n][i];
      });
      var arm = new THREE.Group();
      arm.add(bar(joint.carrier_m, 0.25 * joint.carrier_m, face / 3, paint.link));
      arm.rotation.z = angle;
      arm.position.z = -face / 2;
      link.add(arm);
    });
  }
  function along(object, direction) { object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction); }
  function robot(ground, thick, paint) {
    function rods(frame, ends, of) {
      ends.forEach(function (end) {
        var to = new THREE.Vector3(end[0], end[1], end[2]), rod = new THREE.Mesh(new THREE.CylinderGeometry(thick / 2, thick / 2, to.length(), 16), of);
        rod.position.copy(to).multiplyScalar(0.5);
        along(rod, to.clone().normalize());
        frame.add(rod);
      });
    }
    var bodies = [];
    rods(ground, scene.ground, paint.ring);
    var up = new THREE.Vector3(scene.up[0], scene.up[1], scene.up[2]);
    var foot = new THREE.Mesh(new THREE.CylinderGeometry(5 * thick, 5 * thick, thick, 48), paint.ring);
    foot.position.copy(up).multiplyScalar(-2 * thick);
    along(foot, up);
    ground.add(foot);
    scene.joints.forEach(function (joint) {
      var frame = new THREE.Group(), body = new THREE.Group(), r = joint.rotation, at = joint.position;
      var axis = new THREE.Vector3(joint.axis[0], joint.axis[1], joint.axis[2]), slides = joint.kind === "prismatic";
      var place = new THREE.Matrix4().set(r[0][0], r[0][1], r[0][2], at[0], r[1][0], r[1][1], r[1][2], at[1], r[2][0], r[2][1], r[2][2], at[2], 0, 0, 0, 1);
      frame.applyMatrix4(place);
      (joint.parent < 0 ? ground : bodies[joint.parent]).add(frame);
      var housing = new THREE.Mesh(slides ? new THREE.BoxGeometry(2 * thick, 3 * thick, 2 * thick) : new THREE.CylinderGeometry(thick, thick, 3 * thick, 32), paint.sun);
      along(housing, axis);
      frame.add(housing, body);
      movers.push(function (i) {
        if (slides) { body.position.copy(axis).multiplyScalar(joint.theta[i]); }
        else { body.quaternion.setFromAxisAngle(axis, joint.theta[i]); }
      });
      rods(body, joint.ends, paint.link);
      bodies.push(body);
      places.push(frame);
    });
    places.push(bodies[bodies.length - 1]);
  }
  // What the first ring, or motor, is fixed to: a post towards -y and the plate that it stands on.
  function stand(frame, rim, depth, paint) {
    var post = bar(rim, rim / 3, depth, paint), plate = bar(rim / 4, 3 * rim, 3 * depth, paint);
    post.position.set(0, -1.5 * rim, depth / 2);
    plate.position.set(0, -2.1 * rim, depth / 2);
    post.rotation.z = plate.rotation.z = Math.PI / 2;
    frame.add(post, plate);
  }
  function build() {
    world = new THREE.Scene();
    movers = []; places = [];
    var paint = { ring: material("--soft"), sun: material("--line-1"), planet: material("--line-2"), link: material("--line-3"), payload: material("--line-4") };
    var frame = new THREE.Group(), thick = reach / 60;
    world.add(frame, new THREE.AmbientLight(0xffffff, 1.3));
    var light = new THREE.DirectionalLight(0xffffff, 2.2);
    light.position.set(-0.6, 0.4, 1.5);
    world.add(light);
    if (scene.ground) { robot(frame, thick, paint); survey(); return; }
    var first = scene.joints[0];
    stand(frame, first.rim_m || 1.5 * thick, first.face_m || thick, paint.ring);
    scene.joints.forEach(function (joint) {
      var link = new THREE.Group(), rod = bar(joint.length_m, thick, thick, paint.link);
      rod.position.z = -(joint.face_m || thick) - thick / 2;
      link.add(rod);
      frame.add(link);
      movers.push(function (i) { link.rotation.z = joint.theta[i]; });
      if (joint.kind === "planetary") { gears(joint, frame, link, paint); }
      else {
        var motor = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, 3 * thick, 32), paint.sun);
        motor.rotation.x = Math.PI / 2;
        frame.add(motor);
      }
      places.push(frame);
      var next = new THREE.Group();
      next.position.x = joint.length_m;
      link.add(next);
      frame = next;
    });
    if (scene.payload) { frame.add(new THREE.Mesh(new THREE.SphereGeometry(1.6 * thick, 24, 16), paint.payload)); }
    places.push(frame);
    survey();
  }
  // The space that the run sweeps, which the camera holds in view.
  var swept = null;
  function survey() {
    var box = new THREE.Box3();
    for (var n = 0; n <= 12; n++) {
      movers.forEach(function (move) { move(Math.round((scene.frames - 1) * n / 12)); });
      world.updateMatrixWorld(true);
      box.expandByObject(world);
    }
    swept = box.getBoundingSphere(new THREE.Sphere());
  }

  // ------------------------------------------------------------------ camera
  var eye = { turn: -Math.PI / 2, rise: scene.ground ? 0.5 : 1.05, far: 1, target: -1 };
  function aim(target) {
    eye.target = target;
    var joint = scene.joints[target];
    eye.far = target < 0 ? (swept ? 2.1 * swept.radius : reach) : joint.kind === "planetary" ? 3.6 * joint.rim_m : 0.4 * reach;
  }
  function look() {
    var centre = swept.center.clone();
    if (eye.target >= 0) { places[eye.target].getWorldPosition(centre); }
    var far = eye.far / Math.min(1, camera.aspect), flat = far * Math.cos(eye.rise);
    camera.position.set(centre.x + flat * Math.cos(eye.turn), centre.y + flat * Math.sin(eye.turn), centre.z + far * Math.sin(eye.rise));
    camera.up.set(0, 0, 1);
    camera.lookAt(centre);
  }
  function turn(across, up) {
    eye.turn += across;
    eye.rise = Math.min(Math.max(eye.rise + up, -1.5), 1.5);
    state.dirty = true;
  }
  function near(factor) { eye.far = Math.min(Math.max(eye.far * factor, reach / 200), 20 * reach); state.dirty = true; }

  // ------------------------------------------------------------------ close-up
  function closeUp(i) {
    var chosen = at("mesh").value.split(" "), joint = scene.joints[Number(chosen[0])];
    var mesh = joint && joint.meshes && joint.meshes[chosen[1]];
    if (!mesh) { return; }
    var canvas = at("inset"), pen = canvas.getContext("2d"), size = canvas.width;
    var scale = size / (12 * mesh.module_m);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = colour("--raised");
    pen.fillRect(0, 0, size, canvas.height);
    pen.setTransform(scale, 0, 0, -scale, size / 2, canvas.height / 2);
    function fill(points, paint) {
      pen.beginPath();
      points.forEach(function (p, n) { if (n) { pen.lineTo(p[0], p[1]); } else { pen.moveTo(p[0], p[1]); } });
      pen.closePath();
      pen.fillStyle = paint;
      pen.globalAlpha = 0.85;
      pen.fill();
      pen.globalAlpha = 1;
    }
    mesh.wheel.forEach(function (tooth) { fill(tooth, colour(chosen[1] === "sun" ? "--line-1" : "--soft")); });
    pen.translate(mesh.centre[0], mesh.centre[1]);
    pen.rotate(mesh.turn_per_m * mesh.gap[i]);
    pen.translate(-mesh.centre[0], -mesh.centre[1]);
    mesh.planet.forEach(function (tooth) { fill(tooth, colour("--line-2")); });
    var b = mesh.half_clearance_m, gap = mesh.gap[i], force = mesh.force[i], beyond = Math.abs(gap) - b;
    var contact = force > 0 ? "teeth in contact" : force < 0 ? "in contact on the other side" : "contact lost";
    var micro = function (length) { return (1e6 * length).toFixed(2) + " µm"; };
    at("gap").textContent = "x − e = " + micro(gap) + ", " + (beyond > 0 ? micro(beyond) + " beyond half the backlash of " : "inside half the backlash of ") +
      micro(b) + ": " + contact + "; F = " + force.toPrecision(4) + " N. x: displacement of the mesh, e: tooth error. Gap drawn " +
      mesh.factor.toPrecision(3) + " times larger; rolling of the teeth is not drawn.";
  }

  // ------------------------------------------------------------------ strip chart
  // The force of the chosen mesh, or a joint's motion where no teeth are: what ten seconds of playing cover.
  function charted() {
    var chosen = at("mesh").value.split(" "), joint = scene.joints[Number(chosen[0])];
    if (joint && joint.meshes && joint.meshes[chosen[1]]) {
      return { values: joint.meshes[chosen[1]].force, name: "F of " + at("mesh").selectedOptions[0].textContent, unit: " N" };
    }
    var n = Math.max(eye.target, 0);
    joint = scene.joints[n];
    return { values: joint.theta, name: joint.name || "angle of joint " + (n + 1), unit: joint.kind === "prismatic" ? " m" : " rad" };
  }
  function frames() {
    var count = Math.min(Math.max(Math.round(10 * speed() / scene.step_s), 20), scene.frames - 1);
    var begin = Math.min(Math.max(frame() - Math.round(count / 2), 0), scene.frames - 1 - count);
    return { begin: begin, count: count };
  }
  var LEFT = 58, BELOW = 20;  // room for the labels of the axes [px]
  function ticks(from, to, most) {
    var raw = (to - from) / most || 1, power = Math.pow(10, Math.floor(Math.log10(raw)));
    var step = power * [1, 2, 5, 10].find(function (n) { return n * power >= raw; }), found = [];
    for (var n = Math.ceil(from / step - 1e-9); n * step <= to + 1e-9 * step; n++) { found.push(Number((n * step).toPrecision(12))); }
    return found;
  }
  function chart(i) {
    var shown = charted(), span = frames(), canvas = at("strip"), ratio = Math.min(devicePixelRatio, 2);
    var wide = canvas.clientWidth - LEFT, high = canvas.clientHeight - BELOW, low = Infinity, most = -Infinity, columns = [];
    canvas.width = (wide + LEFT) * ratio; canvas.height = (high + BELOW) * ratio;
    var pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (var k = 0; k <= span.count; k++) {
      var x = LEFT + Math.round((wide - 1) * k / span.count), value = shown.values[span.begin + k], column = columns[x];
      low = Math.min(low, value); most = Math.max(most, value);
      columns[x] = column ? [Math.min(column[0], value), Math.max(column[1], value), value] : [value, value, value];
    }
    var bottom = Math.min(low, 0), top = Math.max(most, 0), y = function (v) { return high - 8 - (high - 16) * (v - bottom) / (top - bottom || 1); };
    function line(paint, width, trace) { pen.beginPath(); pen.strokeStyle = colour(paint); pen.lineWidth = width; trace(); pen.stroke(); }
    pen.fillStyle = colour("--raised");
    pen.fillRect(LEFT, 0, wide, high);
    pen.fillStyle = colour("--soft"); pen.font = "11px system-ui, sans-serif"; pen.textAlign = "right"; pen.textBaseline = "middle";
    ticks(bottom, top, 4).forEach(function (v) {
      line("--line", 1, function () { pen.moveTo(LEFT, y(v)); pen.lineTo(LEFT + wide, y(v)); });
      pen.fillText(Number(v.toPrecision(6)) + shown.unit, LEFT - 5, y(v));
    });
    var start = scene.start_s + scene.step_s * span.begin, end = start + scene.step_s * span.count;
    ticks(start, end, wide / 110).forEach(function (t, n, all) {
      var x = LEFT + (wide - 1) * (t - start) / (end - start);
      line("--line", 1, function () { pen.moveTo(x, 0); pen.lineTo(x, high); });
      pen.textAlign = x > LEFT + wide - 30 ? "right" : "center";
      pen.fillText(t + (n === all.length - 1 ? " s" : ""), x, high + BELOW / 2 + 1);
    });
    line("--soft", 1, function () { pen.moveTo(LEFT, y(0)); pen.lineTo(LEFT + wide, y(0)); });
    line("--ink", 1.5, function () {
      columns.forEach(function (column, x) { pen.lineTo(x, y(column[0])); pen.lineTo(x, y(column[1])); pen.lineTo(x, y(column[2])); });
    });
    var now = LEFT + (wide - 1) * (i - span.begin) / span.count;
    line("--line-2", 3, function () { pen.moveTo(now, 0); pen.lineTo(now, high); });
    var second = function (n) { return (scene.start_s + scene.step_s * n).toPrecision(4); };
    var plain = function (v) { return Math.abs(v) < 1e-7 * Math.max(-low, most) ? "0" : v.toPrecision(4); };  // float32 rounds so
    at("charted").textContent = shown.name + ": " + plain(shown.values[i]) + shown.unit + "; " + plain(low) + " to " +
      plain(most) + shown.unit + " from " + second(span.begin) + " to " + second(span.begin + span.count) + " s";
  }

  // ------------------------------------------------------------------ time
  function frame() { return Math.min(Math.round(state.time / scene.step_s), scene.frames - 1); }
  function draw() {
    var i = frame();
    if (renderer) {
      movers.forEach(function (move) { move(i); });
      world.updateMatrixWorld();
      look();
      renderer.setClearColor(colour("--raised"));
      renderer.render(world, camera);
    }
    closeUp(i);
    chart(i);
    at("time").value = i;
    at("now").textContent = (scene.start_s + scene.step_s * i).toFixed(5) + " s" + scene.joints.map(function (joint, n) {
      return "  " + (joint.name || "θ" + (n + 1)) + " = " + joint.theta[i].toFixed(5) + (joint.kind === "prismatic" ? " m" : " rad");
    }).join("");
    state.drawn += 1;
    state.dirty = false;
  }
  function play(on) {
    state.playing = on;
    at("play").textContent = on ? "pause" : "start";
    at("play").setAttribute("aria-pressed", String(on));
  }
  function speed() { return Math.pow(10, Number(at("speed").value)); }
  function said() { at("slow").textContent = speed() >= 1 ? Number(speed().toPrecision(2)) + " times real time" : "slowed down " + Number((1 / speed()).toPrecision(2)) + " times"; }
  var last = null;
  function tick(now) {
    if (state.playing && last !== null) {
      state.time += speed() * Math.min(now - last, 100) / 1000;
      if (state.time > duration) { state.time = 0; }
      state.dirty = true;
    }
    last = now;
    if (state.dirty) { draw(); }
    requestAnimationFrame(tick);
  }
  function step(by) { play(false); state.time = Math.min(Math.max(frame() + by, 0), scene.frames - 1) * scene.step_s; state.dirty = true; }

  // ------------------------------------------------------------------ controls
  function option(element, value, text) {
    var made = document.createElement("option");
    made.value = value; made.textContent = text;
    element.append(made);
  }
  option(at("target"), -1, scene.ground ? "the whole robot" : "the whole arm");
  scene.joints.forEach(function (joint, n) {
    option(at("target"), n, joint.name || "joint " + (n + 1));
    ["sun", "ring"].filter(function (side) { return joint.meshes && joint.meshes[side]; }).forEach(function (side) {
      option(at("mesh"), n + " " + side, "joint " + (n + 1) + ", " + (side === "sun" ? "sun and planet 1" : "planet 1 and ring"));
    });
  });
  at("close-up").hidden = !at("mesh").options.length;
  at("time").max = scene.frames - 1;
  at("target").onchange = function () { aim(Number(at("target").value)); state.dirty = true; };
  at("mesh").onchange = function () { state.dirty = true; };
  at("play").onclick = function () { play(!state.playing); };
  at("back").onclick = function () { step(-1); };
  at("forth").onclick = function () { step(1); };
  at("time").oninput = function () { play(false); state.time = Number(at("time").value) * scene.step_s; state.dirty = true; };
  at("speed").oninput = function () { said(); state.dirty = true; };
  function seek(event) {
    var span = frames(), box = at("strip").getBoundingClientRect();
    play(false);
    state.time = scene.step_s * (span.begin + span.count * Math.min(Math.max((event.clientX - box.left - LEFT) / (box.width - LEFT), 0), 1));
    state.dirty = true;
  }
  at("strip").onclick = seek;
  at("nearer").onclick = function () { near(0.8); };
  at("farther").onclick = function () { near(1.25); };
  at("arm").onkeydown = function (event) {
    var keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    if (keys[event.key]) { turn.apply(null, keys[event.key]); }
    else if (event.key === "+") { near(0.8); }
    else if (event.key === "-") { near(1.25); }
    else if (event.key === " ") { play(!state.playing); }
    else { return; }
    event.preventDefault();
  };
  var held = null;
  at("arm").onpointerdown = function (event) { held = [event.clientX, event.clientY]; at("arm").setPointerCapture(event.pointerId); };
  at("arm").onpointermove = function (event) {
    if (held) { turn((held[0] - event.clientX) / 200, (event.clientY - held[1]) / 200); held = [event.clientX, event.clientY]; }
  };
  at("arm").onpointerup = function () { held = null; };
  at("arm").onwheel = function (event) { event.preventDefault(); near(event.deltaY > 0 ? 1.1 : 1 / 1.1); };
  function fit() {
    if (renderer) {
      var wide = at("arm").parentElement.clientWidth, high = Math.round(Math.min(0.62 * wide + 60, 400));
      renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
      renderer.setSize(wide, high);
      camera.aspect = wide / high;
      camera.updateProjectionMatrix();
    }
    state.dirty = true;
  }
  if (renderer) {
    camera = new THREE.PerspectiveCamera(45, 1, reach / 1000, 100 * reach);
    build();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", function () { build(); state.dirty = true; });
  }
  window.addEventListener("resize", fit);
  aim(-1);
  at("speed").value = Math.max(-4, Math.min(1, Math.log10(duration / 10)));
  said();
  play(state.playing);
  fit();
  requestAnimationFrame(tick);
  window.view = state;
}
