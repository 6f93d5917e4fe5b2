// Two plots of one signal on one time axis: the runs above, their difference from the reference below.
(function () {
  "use strict";
  var root = document.getElementById("signals");
  var source = document.getElementById("signals-data");
  if (!root || !source || typeof uPlot === "undefined") { return; }
  var data = JSON.parse(source.textContent);
  var colours = ["--line-1", "--line-2", "--line-3", "--line-4", "--line-5", "--line-6", "--line-7"];
  var chosen = { experiment: 0, quantity: "", joint: 1, from: null, to: null, hidden: {} };
  var plots = [];
  var decoded = {};

  function find(id) { return root.querySelector("#" + id); }
  function duration(each) {
    var any = Object.values(each.whole)[0];
    return any.step_s * any.count;
  }
  function experiment() { return data.experiments[chosen.experiment]; }
  function colour(model) {
    var place = [experiment().reference].concat(experiment().others).indexOf(model);
    return getComputedStyle(root).getPropertyValue(colours[place % colours.length]).trim();
  }
  function lineOf(model) {
    return experiment().lines.find(function (line) {
      return line.quantity === chosen.quantity && line.joint === chosen.joint && line.model === model;
    });
  }
  function numbers(level, line) {
    var key = [chosen.experiment, level.start_s, level.count, line.name].join(" ");
    if (!decoded[key]) {
      var text = atob(level.data[line.name]), bytes = new Uint8Array(text.length);
      for (var i = 0; i < text.length; i++) { bytes[i] = text.charCodeAt(i); }
      decoded[key] = new Float32Array(bytes.buffer);
    }
    return decoded[key];
  }
  function level() {  // the full rate of a named window, where all that is shown lies in it
    var inside = experiment().windows.find(function (w) {
      return w.full_rate[chosen.quantity] && chosen.from !== null && w.begin_s <= chosen.from && chosen.to <= w.end_s;
    });
    return (inside ? inside.full_rate : experiment().whole)[chosen.quantity];
  }
  function times(shown) {
    var each = shown.binned ? 2 : 1, found = new Float64Array(each * shown.count);
    for (var i = 0; i < found.length; i++) { found[i] = shown.start_s + shown.step_s * i / each; }
    return found;
  }
  function digits(value, count) {
    return value && Math.abs(value) < 1e-3 ? value.toExponential(count - 1) : value.toPrecision(count);
  }
  function format(value, unit) {
    return value === null || value === undefined ? "–" : digits(value, 6) + " " + unit;
  }

  function options(element, shown, series, unit, title) {
    var style = getComputedStyle(root), ink = style.getPropertyValue("--ink").trim();
    var axis = { stroke: ink, grid: { stroke: style.getPropertyValue("--line").trim(), width: 1 } };
    return {
      width: element.clientWidth, height: 230, title: title, pxAlign: 0,
      cursor: {
        sync: { key: "signals" }, drag: { x: true, y: false, setScale: false },
        bind: { dblclick: function () { return function () { zoom(-Infinity, Infinity); }; } }
      },
      scales: { x: { time: false } },
      axes: [
        Object.assign({ label: "time [s]", size: 44, space: 80, values: function (u, ticks, place, space, step) {
          var decimals = 0;
          while (decimals < 15 && Math.abs(step * Math.pow(10, decimals) % 1 - 0.5) < 0.5 - 1e-6) { decimals += 1; }
          return ticks.map(function (tick) { return tick.toFixed(decimals); });
        } }, axis),
        Object.assign({ label: unit, size: 76, values: function (u, ticks) {
          return ticks.map(function (tick) { return Number(tick.toPrecision(6)).toString(); });
        } }, axis)
      ],
      series: [{ label: "time", value: function (u, v) { return format(v, "s"); } }].concat(
        series.map(function (one) {
          return {
            label: one.label, stroke: one.colour, width: 1.3, points: { show: false },
            show: !chosen.hidden[one.model],
            value: function (u, v) { return format(v, unit); }
          };
        })
      ),
      hooks: { setSelect: [function (u) {
        var left = u.select.left, wide = u.select.width;
        if (wide > 3) {
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          zoom(u.posToVal(left, "x"), u.posToVal(left + wide, "x"));
        }
      }] }
    };
  }

  function draw() {
    var shown = level(), unit = data.quantities[chosen.quantity].unit, x = times(shown);
    var models = [experiment().reference].concat(experiment().others).filter(lineOf);
    var base = numbers(shown, lineOf(experiment().reference));
    var above = [x], below = [x], upper = [], lower = [];
    models.forEach(function (model, place) {
      var own = numbers(shown, lineOf(model)), values = own;
      if (place > 0) {
        values = new Float32Array(own.length);
        for (var i = 0; i < own.length; i++) { values[i] = base[i] + own[i]; }
        below.push(own);
        lower.push({ label: model + " − " + models[0], model: model, colour: colour(model) });
      }
      above.push(values);
      upper.push({ label: model, model: model, colour: colour(model) });
    });
    find("models").querySelectorAll("input").forEach(function (box) { box.disabled = !lineOf(box.name); });
    plots.forEach(function (plot) { plot.destroy(); });
    var name = chosen.quantity + " of joint " + chosen.joint + ", " + experiment().experiment;
    plots = [[find("overlay"), upper, above, name],
             [find("apart"), lower, below, "difference from " + models[0]]].map(function (each) {
      return new uPlot(options(each[0], shown, each[1], unit, each[3]), each[2], each[0]);
    });
    if (chosen.from !== null) {
      plots.forEach(function (plot) { plot.setScale("x", { min: chosen.from, max: chosen.to }); });
    }
    describe(models, unit, shown);
  }

  function describe(models, unit, shown) {
    var visible = models.filter(function (model, place) { return !place || !chosen.hidden[model]; });
    var said = visible.map(function (model, place) {
      var peak = digits(lineOf(model).peak, 4) + " " + unit;
      return place ? model + " differs by at most " + peak : model + " reaches " + peak;
    });
    var meaning = data.quantities[chosen.quantity].meaning;
    find("said").textContent = meaning + ": " + said.join("; ") + " in " + experiment().experiment + ". " +
      (shown.binned ? "Each point is the least or the largest of several records; the named windows show every record."
                    : "Every record is shown, one every " + Number((1e3 * shown.step_s).toPrecision(3)) + " ms.");
    find("overlay").setAttribute("aria-label", said[0]);
    find("apart").setAttribute("aria-label", said.slice(1).join("; ") || "nothing to compare");
    tell(chosen.from === null ? whole() : [chosen.from, chosen.to]);
  }
  function tell(ends) { find("span").textContent = ends[0].toPrecision(5) + " s to " + ends[1].toPrecision(5) + " s"; }

  function whole() {
    var all = experiment().whole[chosen.quantity];
    return [all.start_s, all.start_s + all.step_s * (all.count - 1)];
  }
  function zoom(from, to) {
    var ends = whole(), before = level();
    if (to - from >= ends[1] - ends[0]) { chosen.from = chosen.to = null; }
    else {
      var wide = to - from;
      chosen.from = Math.min(Math.max(from, ends[0]), ends[1] - wide);
      chosen.to = chosen.from + wide;
    }
    if (level() !== before) { draw(); return; }
    var shown = chosen.from === null ? ends : [chosen.from, chosen.to];
    plots.forEach(function (plot) { plot.setScale("x", { min: shown[0], max: shown[1] }); });
    tell(shown);
  }
  function by(factor, shift) {
    var ends = whole(), from = chosen.from === null ? ends[0] : chosen.from;
    var to = chosen.to === null ? ends[1] : chosen.to, wide = (to - from) * factor;
    var middle = (from + to) / 2 + shift * (to - from);
    zoom(middle - wide / 2, middle + wide / 2);
  }

  function select(id, entries, change) {
    var element = find(id);
    element.replaceChildren.apply(element, entries.map(function (entry) {
      var option = document.createElement("option");
      option.value = entry[0]; option.textContent = entry[1];
      return option;
    }));
    element.onchange = function () { change(element.value); draw(); };
    return element;
  }
  function offer() {  // what this experiment has
    var lines = experiment().lines;
    var quantities = Array.from(new Set(lines.map(function (line) { return line.quantity; })));
    var joints = Array.from(new Set(lines.map(function (line) { return line.joint; })));
    if (quantities.indexOf(chosen.quantity) < 0) {
      chosen.quantity = quantities.indexOf("F_sp") < 0 ? quantities[0] : "F_sp";
    }
    if (joints.indexOf(chosen.joint) < 0) { chosen.joint = joints[0]; }
    chosen.from = chosen.to = null;
    select("quantity", quantities.map(function (name) {
      return [name, name + " [" + data.quantities[name].unit + "]"];
    }), function (value) { chosen.quantity = value; }).value = chosen.quantity;
    select("joint", joints.map(function (joint) { return [joint, "joint " + joint]; }),
           function (value) { chosen.joint = Number(value); }).value = chosen.joint;
    var models = [experiment().reference].concat(experiment().others);
    find("models").replaceChildren.apply(find("models"), models.map(function (model) {
      var label = document.createElement("label"), box = document.createElement("input");
      box.type = "checkbox"; box.checked = !chosen.hidden[model]; box.name = model;
      box.onchange = function () { chosen.hidden[model] = !box.checked; draw(); };
      label.append(box, " " + model + (experiment().rigid.indexOf(model) < 0 ? "" : " (rigid)"));
      return label;
    }));
    find("windows").replaceChildren.apply(find("windows"), experiment().windows.map(function (w) {
      var button = document.createElement("button");
      button.type = "button"; button.textContent = w.title;
      button.onclick = function () { zoom(w.begin_s, w.end_s); };
      return button;
    }));
  }

  select("experiment", data.experiments.map(function (each, place) { return [place, each.experiment]; }),
         function (value) { chosen.experiment = Number(value); offer(); });
  find("whole").onclick = function () { zoom(-Infinity, Infinity); };
  find("closer").onclick = function () { by(0.5, 0); };
  find("wider").onclick = function () { by(2, 0); };
  find("earlier").onclick = function () { by(1, -0.5); };
  find("later").onclick = function () { by(1, 0.5); };
  root.hidden = false;
  chosen.experiment = data.experiments.reduce(function (best, each, place) {
    each.rigid.forEach(function (model) { chosen.hidden[model] = true; });  // until they are asked for
    return duration(each) > duration(data.experiments[best]) ? place : best;
  }, 0);
  find("experiment").value = chosen.experiment;
  offer();
  draw();
  window.addEventListener("resize", function () {
    plots.forEach(function (plot) { plot.setSize({ width: plot.root.parentElement.clientWidth, height: 230 }); });
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  root.plots = function () { return plots; };
  root.zoom = zoom;
})();
