#include <algorithm>
#include <cmath>
#include <ostream>

#include "calot/patient/patient_file.h"

namespace calot::detail {
namespace {

/// One line of a comment, whatever the text holds.
std::string comment(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return text;
}

/// A direction to nine decimals: closer than anything that is drawn or computed from it.
std::string direction_text(const Vec3& direction) {
  std::string text = "[";
  for (int axis = 0; axis < 3; ++axis)
    text += (axis == 0 ? "" : ", ") + toml_real(std::round(direction[axis] * 1e9) / 1e9 + 0.0);
  return text + "]";
}

void write_vertices(std::ostream& out, const std::vector<VertexId>& vertices) {
  constexpr std::size_t per_line = 20;
  out << "vertices = [";
  for (std::size_t v = 0; v < vertices.size(); ++v)
    out << (v == 0 ? "\n  " : v % per_line == 0 ? ",\n  " : ", ") << vertices[v].value;
  out << "\n]\n";
}

void write_header(std::ostream& out, const Patient& patient, const std::string& made_by) {
  out << "# A patient for Calot. Change what you like, then see what is wrong: calot patient --check FOLDER\n"
         "#\n"
         "# Places are in the patient's own axes, RAS: x grows to the patient's right, y to the front, z to the head;\n"
         "# lengths in millimetres, angles in degrees, Young's modulus in Pa, density in kg/m3. Directions need not "
         "have\n"
         "# length 1. Vertices count from 0, in the order of the mesh file. Whole numbers are fine where reals are "
         "meant.\n"
         "\n"
      << "format = 1              # of this file\n"
      << "name = " << toml_text(patient.name) << '\n'
      << "made_by = " << toml_text(made_by) << '\n'
      << "orientation = \"RAS\"     # nothing else is read\n"
      << "length_unit = \"mm\"      # nothing else is read\n";
}

void write_files(std::ostream& out, const Patient& patient) {
  out << "\n# The files beside this one.\n[files]\n"
      << "mesh = \"mesh.msh\"                     # tetrahedra, mm; mesh.vtu is the same for ParaView\n"
      << "model = \"model.toml\"                  # for calot precompute; has materials and supports of its own\n";
  if (!patient.lines.empty())
    out << "centrelines = \"centrelines.mrk.json\"  # middle lines of ducts and arteries with radii, for 3D Slicer\n";
  out << "labels = \"labels.nii.gz\"              # the voxels that were meshed\n"
      << "quality = \"quality.json\"              # of the mesh\n"
      << "provenance = \"provenance.json\"        # where everything comes from, with hashes of these files\n";
}

void write_regions(std::ostream& out, const Patient& patient) {
  out << "\n# The organs: what each is made of (linear, isotropic) and how it looks. The label is the region's number "
         "in mesh\n"
         "# and label map. The colour is sRGB, 0 to 1; textures are projected along the three axes, repeat every\n"
         "# texture_size, and are blended by the normal to the power of blend_sharpness.\n";
  for (const auto& [structure, material] : patient.materials) {
    out << "\n[[region]]\n"
        << "label = " << label_of(structure) << '\n'
        << "name = " << toml_text(std::string(name_of(structure))) << '\n'
        << "surface = " << toml_text(surface_name(structure)) << '\n'
        << "young = " << toml_real(material.young) << "  # Pa\n"
        << "poisson = " << toml_real(material.poisson) << '\n'
        << "density = " << toml_real(material.density) << "  # kg/m3\n"
        << "source = " << toml_text(material.source) << '\n';
    const auto found = patient.appearances.find(structure);
    if (found == patient.appearances.end()) continue;
    const Appearance& look = found->second;
    out << "colour = [" << toml_real(look.red) << ", " << toml_real(look.green) << ", " << toml_real(look.blue) << "]\n"
        << "texture_size = " << toml_mm(look.texture_size) << "  # mm\n"
        << "blend_sharpness = " << toml_real(look.blend_sharpness) << '\n';
  }
}

void write_attachments(std::ostream& out, const Patient& patient) {
  out << "\n# What holds the organs. kind = \"fixed\": held in place. kind = \"peritoneum\": held by a membrane that "
         "gives, and\n"
         "# that is cut in the operation.\n";
  for (const Attachment& attachment : patient.attachments) {
    out << "\n[[attachment]]\n"
        << "name = " << toml_text(attachment.name) << '\n'
        << "kind = " << (attachment.kind == AttachmentKind::fixed ? "\"fixed\"" : "\"peritoneum\"") << '\n'
        << "reason = " << toml_text(attachment.reason) << '\n';
    write_vertices(out, attachment.vertices);
  }
}

void write_border_cuts(std::ostream& out, const Patient& patient) {
  if (patient.border_cuts.empty()) return;
  out << "\n# Where the CT's border cuts an organ: the cut face is held (see the attachments). The axis is one of the "
         "CT's\n"
         "# grid, i, j or k; upper: at its last voxel.\n";
  for (const BorderCut& cut : patient.border_cuts)
    out << "\n[[border_cut]]\n"
        << "structure = " << toml_text(std::string(name_of(cut.structure))) << '\n'
        << "axis = \""
        << "ijk"[cut.axis] << "\"\n"
        << "upper = " << (cut.upper ? "true" : "false") << '\n'
        << "point = " << toml_mm(cut.point) << "  # on the cutting plane\n"
        << "normal = " << direction_text(cut.normal) << "  # out of the CT\n"
        << "area = " << toml_real(cut.area * 1e6) << "  # mm2\n";
}

void write_views(std::ostream& out, const Landmarks& marks) {
  out << "\n# Calot's triangle, where the operation's decisive dissection happens.\n[calot_triangle]\n"
      << "duct_corner = " << toml_mm(marks.triangle.duct_corner) << "  # cystic duct meets the hepatic duct\n"
      << "neck_corner = " << toml_mm(marks.triangle.neck_corner) << "  # cystic duct meets the gallbladder\n"
      << "liver_corner = " << toml_mm(marks.triangle.liver_corner) << "  # hepatic duct and liver edge meet\n"
      << "\n# Where instruments enter: on the inner side of the lifted abdominal wall.\n";
  for (const Port& port : marks.ports)
    out << "\n[[port]]\n"
        << "name = " << toml_text(port.name) << '\n'
        << "position = " << toml_mm(port.position) << '\n'
        << "diameter = " << toml_mm(port.diameter) << "  # mm\n"
        << "purpose = " << toml_text(port.purpose) << '\n';
  out << "\n# The laparoscope at the beginning.\n[camera]\n"
      << "tip = " << toml_mm(marks.camera.tip) << '\n'
      << "target = " << toml_mm(marks.camera.target) << "  # what it looks at\n"
      << "up = " << direction_text(marks.camera.up) << "  # of the picture\n"
      << "oblique = " << toml_real(marks.camera.oblique) << "  # degrees, of its optic\n"
      << "field_of_view = " << toml_real(marks.camera.field_of_view) << "  # degrees\n";
}

void write_sites(std::ostream& out, const char* kind, const std::vector<TubeSite>& sites) {
  for (const TubeSite& site : sites)
    out << "\n[[" << kind << "]]\n"
        << "name = " << toml_text(site.name) << '\n'
        << "tube = " << toml_text(std::string(name_of(site.tube))) << '\n'
        << "arc_length = " << toml_mm(site.arc_length) << "  # mm\n"
        << "position = " << toml_mm(site.position) << '\n'
        << "direction = " << direction_text(site.direction) << '\n'
        << "radius = " << toml_mm(site.radius) << "  # mm\n";
}

void write_notes(std::ostream& out, const Landmarks& marks) {
  if (marks.notes.empty()) return;
  out << "\n# What had to be assumed.\n[landmarks]\nnotes = [\n";
  for (const std::string& note : marks.notes) out << "  " << toml_text(note) << ",\n";
  out << "]\n";
}

}  // namespace

std::string file_stem(Structure s) {
  std::string stem(name_of(s));
  std::replace(stem.begin(), stem.end(), ' ', '_');
  return stem;
}

std::string surface_name(Structure s) {
  return "surfaces/" + file_stem(s) + ".ply";
}

void write_patient_toml(std::ostream& out, const Patient& patient, const std::string& made_by) {
  write_header(out, patient, made_by);
  write_files(out, patient);
  write_regions(out, patient);
  write_attachments(out, patient);
  write_border_cuts(out, patient);
  write_views(out, patient.landmarks);
  out << "\n# Where tubes are clipped and cut. arc_length is measured along the tube's centreline from its end away "
         "from\n"
         "# the gallbladder; direction is the tube's there, towards the gallbladder. To move one, change arc_length "
         "and\n"
         "# delete position, direction and radius, or change position and delete the others: what isn't there is "
         "taken\n"
         "# from the centreline. Of each tube: two clips, the cut, a clip on the gallbladder's side.\n";
  write_sites(out, "clip", patient.landmarks.clips);
  write_sites(out, "cut", patient.landmarks.cuts);
  write_notes(out, patient.landmarks);
}

void write_model_toml(std::ostream& out, const Patient& patient, const std::string& made_by) {
  out << "# The patient's mechanics, by " << comment(made_by) << ": calot precompute reads it.\n"
      << "mesh = \"mesh.msh\"      # coordinates: patient, right-anterior-superior\n"
      << "length_unit = \"mm\"     # of the mesh file\n"
      << "time_step = 0.02       # s; 0 = static\n";
  for (const auto& [structure, material] : patient.materials)
    out << "\n[[material]]  # " << name_of(structure) << ": " << comment(material.source) << '\n'
        << "region = " << label_of(structure) << '\n'
        << "young = " << toml_real(material.young) << "  # Pa\n"
        << "poisson = " << toml_real(material.poisson) << '\n'
        << "density = " << toml_real(material.density) << "  # kg/m3\n";
  for (const Attachment& attachment : patient.attachments) {
    if (attachment.kind != AttachmentKind::fixed) continue;
    out << "\n[[fixed]]  # " << comment(attachment.name) << ": " << comment(attachment.reason) << '\n';
    write_vertices(out, attachment.vertices);
  }
}

}  // namespace calot::detail
