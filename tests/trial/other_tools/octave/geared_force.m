function f = geared_force(arm, x, v, torque)
  % Forces of two planetary gears, planets lumped: meshes, dampers, friction and drive.
  f = zeros(6, 1);
  for k = 1:2
    joint = arm.joints{k}; at = 3 * k - [2, 1, 0];
    count = joint.planet_count;
    cosine = cosd(joint.pressure_angle_deg);
    r_s = joint.module_m * joint.sun_teeth / 2 * cosine;
    r_cp = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2 * cosine;
    ratio = 1 + joint.ring_teeth / joint.sun_teeth;
    f(at) = torque(k) / ratio / r_s * [1; 1; 2 * r_cp];
    f(at(3)) = f(at(3)) - joint.friction_N_m_s_per_rad * v(at(3));
    meshes = {joint.sun_mesh, joint.ring_mesh};
    masses = [joint.sun_equivalent_mass_kg, count * joint.planet_equivalent_mass_kg];
    for side = 1:2
      mesh = meshes{side};
      sine = sin(joint.ring_teeth * x(at(3)) + mesh.phase_rad);
      gap = x(at(side)) - mesh.tooth_error_m * sine;
      pressed = gap - min(max(gap, -mesh.backlash_m), mesh.backlash_m);
      mean = mesh.stiffness.mean_N_per_m;
      if isfield(mesh, 'damping_N_s_per_m')
        d = mesh.damping_N_s_per_m;
      else
        d = 2 * mesh.damping_ratio * sqrt(count * mean * masses(side));
      end
      k_mesh = mean + mesh.stiffness.amplitude_N_per_m * sine;
      f(at(side)) = f(at(side)) - count * k_mesh * pressed - d * v(at(side));
    end
  end
end
