function [M, h, f] = two_link(arm, q, v, torque)
  % Two links and a payload in absolute angles.
  one = arm.links{1}; two = arm.links{2}; payload = arm.payload_mass_kg;
  [m1, I1] = mass_and_inertia(one);
  [m2, I2] = mass_and_inertia(two);
  L1 = one.length_m; L2 = two.length_m; d1 = one.com_m; d2 = two.com_m;
  c1 = arm.joints{1}.friction_N_m_s_per_rad; c2 = arm.joints{2}.friction_N_m_s_per_rad;
  coupling = (m2 * d2 + payload * L2) * L1;
  far = I2 + m2 * d2 ^ 2 + payload * L2 ^ 2;
  near = I1 + m1 * d1 ^ 2 + (m2 + payload) * L1 ^ 2;
  angle = q(1) - q(2);
  M = [near, coupling * cos(angle); coupling * cos(angle), far];
  h = coupling * sin(angle) * [v(2) ^ 2; -v(1) ^ 2];
  rubbed = c2 * (v(2) - v(1));
  f = [torque(1) - torque(2) - c1 * v(1) + rubbed; torque(2) - rubbed];
end

function [m, I] = mass_and_inertia(link)
  m = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m;
  I = m * link.length_m ^ 2 / 12;
end
