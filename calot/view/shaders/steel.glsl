// Instruments, plain.
Material steel(int substance, vec3 place, vec3 grain) {
  Material m;
  bool plastic = substance == 2;
  m.base = plastic ? vec3(0.012) : substance == 3 ? vec3(0.7, 0.66, 0.58) : vec3(0.62, 0.62, 0.63);
  m.metal = substance == 2 || substance == 3 ? 0.0 : 1.0;
  m.roughness = substance == 1 ? 0.18 : plastic ? 0.45 : 0.32;
  m.coat = 0.0;
  m.coat_roughness = 0.2;
  m.subsurface = vec3(0.0);
  m.height = 0.0;
  m.ao = 1.0;
  return m;
}
