// Helpers of tissue.glsl: how textures are laid on a body, and edges that don't look airbrushed.

// Turned against the axes by angles that no lattice has: flat slices of the periodic volume then never repeat.
const mat3 turned_lattice = mat3(0.7071, 0.5417, -0.4545, -0.6428, 0.7660, -0.0870, 0.2947, 0.3463, 0.8906);

// Weights of the three planes for a normal; sharp, so that patterns cross only along narrow bands.
vec3 plane_weights(vec3 normal) {
  vec3 w = normal * normal;
  w *= w;
  w *= w;
  return w / max(w.x + w.y + w.z, 1e-6);
}

// A tile laid along all three planes.
vec4 laid_on_planes(sampler2D tile, vec3 at, vec3 normal) {
  vec3 w = plane_weights(normal);
  return w.x * texture(tile, at.yz) + w.y * texture(tile, at.zx + 0.37) + w.z * texture(tile, at.xy + 0.71);
}

// The same along the nearest plane only. The level comes from `at`, which doesn't jump where the plane changes.
vec4 laid_on_nearest_plane(sampler2D tile, vec3 at, vec3 normal) {
  vec3 n = abs(normal);
  vec2 uv = n.x > n.y && n.x > n.z ? at.yz : n.y > n.z ? at.zx + 0.37 : at.xy + 0.71;
  vec3 a = dFdx(at), b = dFdy(at);
  float texels = float(textureSize(tile, 0).x);
  return textureLod(tile, uv, 0.5 * log2(max(max(dot(a, a), dot(b, b)) * texels * texels, 1.0)));
}

// How much of a painted mask shows: its soft edge broken up by noise (0 ... 1); none where the mask is 0, all where 1.
float ragged(float mask, float noise, float low, float high) {
  float band = 4.0 * mask * (1.0 - mask);
  return smoothstep(low, high, mask + (noise - 0.5) * band * 0.9);
}
