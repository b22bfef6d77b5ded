// What a surface is made of at a point. Colours are linear.
struct Material {
  vec3 base;             // diffuse colour; of metal, its reflection
  float roughness;       // of the surface itself, 0 ... 1
  float coat;            // how much of it is covered by a wet film, 0 ... 1
  float coat_roughness;  // of that film
  vec3 subsurface;       // how far light goes round edges in each colour, 0 ... 1
  float height;          // of the fine relief [m]
  float metal;           // 0 ... 1
  float ao;              // how open fine creases are, 0 ... 1
};
