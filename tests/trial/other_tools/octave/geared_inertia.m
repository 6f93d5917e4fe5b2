function M = geared_inertia(arm, x)
  % Mass matrix of two planetary gears, planets lumped, in the paper's coordinates.
  U = eye(6); phi = {U(:, 3), U(:, 3) + U(:, 6)};
  one = arm.links{1}; two = arm.links{2}; payload = arm.payload_mass_kg;
  [m1, I1] = mass_and_inertia(one);
  [m2, I2] = mass_and_inertia(two);
  elbow = arm.joints{2};
  carried = m2 + payload + elbow.sun_mass_kg + elbow.carrier_mass_kg + elbow.ring_mass_kg;
  carried = carried + elbow.planet_count * elbow.planet_mass_kg;
  M = (I1 + m1 * one.com_m ^ 2 + carried * one.length_m ^ 2) * square(phi{1});
  M = M + (I2 + m2 * two.com_m ^ 2 + payload * two.length_m ^ 2) * square(phi{2});
  for k = 1:2
    joint = arm.joints{k};
    count = joint.planet_count;
    cosine = cosd(joint.pressure_angle_deg);
    r_s = joint.module_m * joint.sun_teeth / 2 * cosine;
    r_p = joint.module_m * joint.planet_teeth / 2 * cosine;
    r_c = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2;
    before = (k - 1) * phi{1};
    x_sp = U(:, 3 * k - 2); x_pr = U(:, 3 * k - 1); theta = U(:, 3 * k);
    sun = x_sp + x_pr + 2 * r_c * cosine * theta + r_s * before;
    planet = x_pr + r_c * cosine * theta - r_p * before;
    orbit = joint.carrier_equivalent_mass_kg * (r_c * cosine) ^ 2;
    orbit = orbit + count * joint.planet_mass_kg * r_c ^ 2;
    M = M + joint.sun_equivalent_mass_kg * square(sun);
    M = M + count * joint.planet_equivalent_mass_kg * square(planet);
    M = M + orbit * square(phi{k}) + joint.ring_inertia_kg_m2 * square(before);
  end
  coupling = one.length_m * (m2 * two.com_m + payload * two.length_m);
  M = M + coupling * cos(x(6)) * (phi{1} * phi{2}' + phi{2} * phi{1}');
end

function A = square(row)
  A = row * row';
end

function [m, I] = mass_and_inertia(link)
  m = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m;
  I = m * link.length_m ^ 2 / 12;
end
