// Tissue's looks, plain: one colour each.
Material tissue(int look, bool cut, vec3 rest, vec3 rest_normal, vec4 condition, vec4 mask, bool lite) {
  vec3 colors[8] = vec3[8](vec3(0.50, 0.22, 0.18), vec3(0.20, 0.045, 0.035), vec3(0.30, 0.36, 0.20),
                           vec3(0.56, 0.42, 0.26), vec3(0.60, 0.16, 0.13), vec3(0.72, 0.52, 0.22),
                           vec3(0.55, 0.30, 0.25), vec3(0.60, 0.28, 0.24));
  Material m;
  m.base = cut ? mix(colors[look], vec3(0.45, 0.06, 0.05), 0.6) : colors[look];
  m.base = mix(m.base, vec3(0.70, 0.62, 0.52), condition.x);
  m.base = mix(m.base, vec3(0.02), condition.y);
  m.base = mix(m.base, vec3(0.30, 0.005, 0.005), mask.x);
  m.roughness = 0.5;
  m.coat = 1.0 - condition.y;
  m.coat_roughness = 0.2;
  m.subsurface = vec3(0.35, 0.12, 0.08);
  m.height = 0.0;
  m.metal = 0.0;
  m.ao = 1.0;
  return m;
}
