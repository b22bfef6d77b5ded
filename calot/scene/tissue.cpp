#include "calot/scene/tissue.h"

#include <set>

#include "calot/base/error.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/scene/ligaments.h"
#include "calot/scene/region_figures.h"
#include "calot/scene/shape_mesh.h"

namespace calot {
namespace {

/// Everything that makes a Model, before the scene's regions have their say.
struct Parts {
  TetMesh mesh;
  std::map<std::int32_t, Material> materials;
  std::vector<std::uint8_t> fixed;
  Dynamics dynamics;
  Origin origin;
  std::optional<Patient> patient;
  std::vector<double> masses, stiffness_scale;  // as the model has them; empty for the usual ones
  std::vector<VertexId> hung;                   // what holds rigid regions, ascending
};

Parts of_patient(const Scene& scene) {
  Parts parts;
  parts.patient = load_patient(scene.patient);
  parts.mesh = std::move(parts.patient->mesh);
  parts.patient->mesh = {};
  for (const auto& [structure, m] : parts.patient->materials)
    parts.materials[label_of(structure)] = {m.young, m.poisson, m.density};
  parts.fixed.assign(parts.mesh.vertex_count(), 0);
  for (const Attachment& attachment : parts.patient->attachments)
    if (attachment.kind == AttachmentKind::fixed)
      for (const VertexId v : attachment.vertices) parts.fixed[v.index()] = 1;
  return parts;
}

Parts of_model(const Scene& scene) {
  const Model model = load_model(scene.model);
  Parts parts;
  parts.mesh = model.mesh();
  parts.materials = model.materials();
  parts.fixed = model.fixed();
  parts.dynamics = model.dynamics();
  parts.origin = model.origin();
  if (parts.dynamics.mass_lumping == MassLumping::uniform) parts.masses = model.vertex_masses();
  if (model.has_scaled_stiffness()) parts.stiffness_scale = model.stiffness_scale();
  return parts;
}

Parts of_shapes(const Scene& scene) {
  ShapeMesh shapes = mesh_of_shapes(scene.blocks, scene.tubes);
  Parts parts;
  parts.mesh = std::move(shapes.mesh);
  parts.fixed = std::move(shapes.fixed);
  for (const auto& [region, name] : parts.mesh.region_names) {
    const auto structure = structure_named(name);
    const TissueMaterial m = material_of(structure.value_or(Structure::liver));
    parts.materials[region] = {m.young, m.poisson, m.density};
  }
  return parts;
}

void set_figures(const RegionSettings& settings, Material& material, TissueProperties& properties) {
  for (const auto& [key, value] : settings.figures) {
    const detail::RegionFigure* figure = detail::region_figure(key);
    if (figure == nullptr) throw InputError(settings.where, "a region has no figure \"" + key + "\"");
    if (figure->material != nullptr) material.*(figure->material) = value;
    if (figure->property != nullptr) properties.*(figure->property) = value;
  }
}

/// Whether what holds a region gives way: that of rigid ones, and of a patient's liver. Deformable as it is, a liver
/// that is held in place tears before its edge is up 30 mm.
bool hangs(const Parts& parts, std::int32_t region, BodyKind kind) {
  return kind == BodyKind::rigid ||
         (kind == BodyKind::deformable && parts.patient && region == label_of(Structure::liver));
}

/// What held such a region in place becomes what its ligaments hold, but where a static region holds it too.
void hang_regions(Parts& parts, const std::map<std::int32_t, BodyKind>& bodies) {
  std::vector<std::uint8_t> still(parts.mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < parts.mesh.tet_count(); ++t)
    if (bodies.at(parts.mesh.regions[t]) == BodyKind::still)
      for (const VertexId v : parts.mesh.tets[t]) still[v.index()] = 1;
  std::set<VertexId> held;
  for (std::size_t t = 0; t < parts.mesh.tet_count(); ++t) {
    if (!hangs(parts, parts.mesh.regions[t], bodies.at(parts.mesh.regions[t]))) continue;
    for (const VertexId v : parts.mesh.tets[t])
      if (parts.fixed[v.index()] && !still[v.index()]) held.insert(v);
  }
  for (const VertexId v : held) parts.fixed[v.index()] = 0;
  parts.hung.assign(held.begin(), held.end());
}

void apply_regions(const Scene& scene, Parts& parts, std::map<std::int32_t, TissueProperties>& properties,
                   std::map<std::int32_t, BodyKind>& bodies) {
  properties = tissue_properties(parts.mesh);
  for (auto& [region, p] : properties) {
    bodies[region] = BodyKind::deformable;
    p.density = parts.materials.at(region).density;
  }
  for (const RegionSettings& settings : scene.regions)
    for (const std::int32_t region : regions_matching(parts.mesh, settings.region, settings.where)) {
      if (settings.body) bodies[region] = *settings.body;
      set_figures(settings, parts.materials.at(region), properties.at(region));
      const auto name = parts.mesh.region_names.find(region);
      try {
        check(properties.at(region), name == parts.mesh.region_names.end() ? settings.region : name->second);
      } catch (const InputError& wrong) {
        throw InputError(settings.where, wrong.what());
      }
    }
  for (const auto& [region, kind] : bodies)
    if (kind == BodyKind::rigid) parts.materials.at(region).young *= rigid_stiffening;
  hang_regions(parts, bodies);
  for (std::size_t t = 0; t < parts.mesh.tet_count(); ++t)
    if (bodies.at(parts.mesh.regions[t]) == BodyKind::still)
      for (const VertexId v : parts.mesh.tets[t]) parts.fixed[v.index()] = 1;
}

/// A CT shows tissue as it lies under its weight: a patient's is in balance there unless the scene says otherwise.
std::set<std::int32_t> carried_regions(const Scene& scene, const SceneTissue& tissue) {
  std::set<std::int32_t> carried;
  if (tissue.patient)
    for (const auto& [region, kind] : tissue.bodies) carried.insert(region);
  for (const RegionSettings& settings : scene.regions) {
    if (!settings.carried) continue;
    for (const std::int32_t region : regions_matching(tissue.model.mesh(), settings.region, settings.where))
      if (*settings.carried)
        carried.insert(region);
      else
        carried.erase(region);
  }
  return carried;
}

}  // namespace

SceneTissue load_tissue(const Scene& scene) {
  Parts parts = !scene.patient.empty() ? of_patient(scene) : !scene.model.empty() ? of_model(scene) : of_shapes(scene);
  if (parts.mesh.tets.empty()) throw InputError(scene.file.string(), "the scene has no tissue", "add a [[block]]");
  std::map<std::int32_t, TissueProperties> properties;
  std::map<std::int32_t, BodyKind> bodies;
  apply_regions(scene, parts, properties, bodies);
  parts.dynamics.time_step = scene.time_step;
  parts.dynamics.rayleigh_mass = scene.rayleigh_mass;
  parts.dynamics.rayleigh_stiffness = scene.rayleigh_stiffness;
  Model model(std::move(parts.mesh), std::move(parts.materials), std::move(parts.fixed), parts.dynamics, {},
              parts.origin);
  if (!parts.masses.empty()) model.set_vertex_masses(std::move(parts.masses));
  if (!parts.stiffness_scale.empty()) {
    std::vector<TetId> all;
    for (std::size_t t = 0; t < model.mesh().tet_count(); ++t) all.emplace_back(t);
    (void)model.scale_stiffness(all, parts.stiffness_scale);
  }
  SceneTissue tissue{std::move(model), std::move(properties), std::move(bodies), {}, {}, std::move(parts.patient)};
  tissue.carried = carried_regions(scene, tissue);
  tissue.ligaments = detail::hang(tissue.model, parts.hung, tissue.carried, scene.gravity);
  return tissue;
}

std::optional<Vec3> port_of(const SceneInstrument& instrument, const SceneTissue& tissue) {
  if (instrument.port) return instrument.port;
  if (instrument.port_name.empty()) return {};
  std::vector<std::string> names;
  if (tissue.patient)
    for (const Port& port : tissue.patient->landmarks.ports) {
      if (port.name == instrument.port_name) return port.position;
      names.push_back(port.name);
    }
  throw InputError(instrument.where, "there is no port \"" + detail::brief(instrument.port_name) + "\"",
                   names.empty() ? "ports have names in patients only; give a place"
                                 : detail::suggestion(instrument.port_name, names));
}

Surface load_surface(const SceneSurface& still) {
  if (!still.file.empty()) return read_surface(still.file, still.scale);
  const Vec3 x = 0.5 * still.size * still.normal.unitOrthogonal(), y = still.normal.cross(x);
  Surface square;
  square.positions = {still.point - x - y, still.point + x - y, still.point + x + y, still.point - x + y};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  return square;
}

std::vector<Surface> load_surfaces(const Scene& scene) {
  std::vector<Surface> surfaces;
  for (const SceneSurface& still : scene.surfaces) surfaces.push_back(load_surface(still));
  return surfaces;
}

}  // namespace calot
