// What all shaders of one picture share.
layout(std140) uniform Frame {
  mat4 view_projection;
  mat4 light_view_projection;
  vec4 eye;          // w: exposure
  vec4 right;        // unit; w: tan of half the horizontal field
  vec4 up;           // unit; w: tan of half the vertical field
  vec4 forward;      // unit; w: near plane [m]
  vec4 light;        // w: power, in units where it gives 1 at 1 m
  vec4 light_axis;   // unit; w: far plane [m]
  vec4 viewport;     // width, height, 1 / width, 1 / height [pixels]
  vec4 ambient;      // light that comes from everywhere; w: shadow map's texel
  vec4 gas;          // x: how much light the gas takes away [1/m]
  vec4 scope;        // radius of the round field [pixels], 0: none; 1 / radius; barrel; chromatic
};

// Distance along the view axis [m] of a depth-buffer value.
float view_depth(float depth) {
  float near = forward.w, far = light_axis.w;
  return near * far / (far - depth * (far - near));
}
