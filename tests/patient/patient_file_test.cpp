#include <gtest/gtest.h>

#include <set>

#include "calot/base/files.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/surface_parameters.h"
#include "tests/patient/small_patient.h"
#include "tests/support/files.h"

namespace {

using namespace calot;
using namespace calot::test;

constexpr double nanometre = 1e-9;

void expect_near(const Vec3& a, const Vec3& b, const std::string& what) {
  EXPECT_LE((a - b).norm(), nanometre) << what;
}

void expect_same(const TubeSite& a, const TubeSite& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.tube, b.tube);
  EXPECT_NEAR(a.arc_length, b.arc_length, nanometre);
  EXPECT_NEAR(a.radius, b.radius, nanometre);
  expect_near(a.position, b.position, a.name);
  expect_near(a.direction, b.direction, a.name);
}

void expect_same(const Landmarks& a, const Landmarks& b) {
  ASSERT_EQ(a.ports.size(), b.ports.size());
  for (std::size_t p = 0; p < a.ports.size(); ++p) {
    EXPECT_EQ(a.ports[p].name, b.ports[p].name);
    EXPECT_EQ(a.ports[p].purpose, b.ports[p].purpose);
    EXPECT_NEAR(a.ports[p].diameter, b.ports[p].diameter, nanometre);
    expect_near(a.ports[p].position, b.ports[p].position, a.ports[p].name);
  }
  expect_near(a.camera.tip, b.camera.tip, "tip");
  expect_near(a.camera.target, b.camera.target, "target");
  expect_near(a.camera.up, b.camera.up, "up");
  EXPECT_EQ(a.camera.oblique, b.camera.oblique);
  EXPECT_EQ(a.camera.field_of_view, b.camera.field_of_view);
  ASSERT_EQ(a.clips.size(), b.clips.size());
  for (std::size_t c = 0; c < a.clips.size(); ++c) expect_same(a.clips[c], b.clips[c]);
  ASSERT_EQ(a.cuts.size(), b.cuts.size());
  for (std::size_t c = 0; c < a.cuts.size(); ++c) expect_same(a.cuts[c], b.cuts[c]);
  expect_near(a.triangle.duct_corner, b.triangle.duct_corner, "duct corner");
  expect_near(a.triangle.neck_corner, b.triangle.neck_corner, "neck corner");
  expect_near(a.triangle.liver_corner, b.triangle.liver_corner, "liver corner");
  EXPECT_EQ(a.notes, b.notes);
}

void expect_same(const Patient& a, const Patient& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.mesh.vertex_count(), b.mesh.vertex_count());
  for (std::size_t v = 0; v < a.mesh.vertex_count(); ++v)
    EXPECT_LE((a.mesh.positions[v] - b.mesh.positions[v]).norm(), nanometre);
  EXPECT_EQ(a.mesh.tets, b.mesh.tets);
  EXPECT_EQ(a.mesh.regions, b.mesh.regions);
  EXPECT_EQ(a.mesh.region_names, b.mesh.region_names);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (const auto& [s, material] : a.materials) {
    const TissueMaterial& other = b.materials.at(s);
    EXPECT_EQ(material.young, other.young);
    EXPECT_EQ(material.poisson, other.poisson);
    EXPECT_EQ(material.density, other.density);
    EXPECT_EQ(material.source, other.source);
    const Appearance &look = a.appearances.at(s), &seen = b.appearances.at(s);
    EXPECT_EQ(look.red, seen.red);
    EXPECT_EQ(look.green, seen.green);
    EXPECT_EQ(look.blue, seen.blue);
    EXPECT_NEAR(look.texture_size, seen.texture_size, nanometre);
    EXPECT_EQ(look.blend_sharpness, seen.blend_sharpness);
  }
  ASSERT_EQ(a.attachments.size(), b.attachments.size());
  for (std::size_t i = 0; i < a.attachments.size(); ++i) {
    EXPECT_EQ(a.attachments[i].name, b.attachments[i].name);
    EXPECT_EQ(a.attachments[i].kind, b.attachments[i].kind);
    EXPECT_EQ(a.attachments[i].reason, b.attachments[i].reason);
    EXPECT_EQ(a.attachments[i].vertices, b.attachments[i].vertices);
  }
  ASSERT_EQ(a.lines.size(), b.lines.size());
  for (std::size_t l = 0; l < a.lines.size(); ++l) {
    EXPECT_EQ(a.lines[l].name, b.lines[l].name);
    ASSERT_EQ(a.lines[l].points.size(), b.lines[l].points.size());
    for (std::size_t p = 0; p < a.lines[l].points.size(); ++p) {
      expect_near(a.lines[l].points[p], b.lines[l].points[p], a.lines[l].name);
      EXPECT_NEAR(a.lines[l].radii[p], b.lines[l].radii[p], nanometre);
    }
  }
  ASSERT_EQ(a.border_cuts.size(), b.border_cuts.size());
  for (std::size_t c = 0; c < a.border_cuts.size(); ++c) {
    EXPECT_EQ(a.border_cuts[c].structure, b.border_cuts[c].structure);
    EXPECT_EQ(a.border_cuts[c].axis, b.border_cuts[c].axis);
    EXPECT_EQ(a.border_cuts[c].upper, b.border_cuts[c].upper);
    expect_near(a.border_cuts[c].point, b.border_cuts[c].point, "border cut");
    expect_near(a.border_cuts[c].normal, b.border_cuts[c].normal, "border cut");
    EXPECT_NEAR(a.border_cuts[c].area, b.border_cuts[c].area, 1e-12);
  }
  expect_same(a.landmarks, b.landmarks);
}

/// Numbers that no rounding to a handful of digits would keep.
Patient crooked_patient() {
  Patient patient = small_patient();
  Random random(7);
  const auto shake = [&](Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += random.between(-1e-4, 1e-4);
  };
  for (Vec3& p : patient.mesh.positions) shake(p);
  for (Centreline& line : patient.lines)
    for (Vec3& p : line.points) shake(p);
  Landmarks& marks = patient.landmarks;
  for (Port& port : marks.ports) shake(port.position);
  for (auto* sites : {&marks.clips, &marks.cuts})
    for (TubeSite& site : *sites) {
      shake(site.position);
      site.direction = (site.direction + Vec3(0.1 * random.unit(), 0.1 * random.unit(), 0)).normalized();
      site.arc_length *= 1 + 1e-3 * random.unit();
      site.radius *= 1 + 1e-3 * random.unit();
    }
  marks.camera.up = Vec3(random.unit(), random.unit(), 1).normalized();
  marks.camera.oblique = 45 * random.unit();
  shake(marks.camera.tip);
  shake(marks.triangle.liver_corner);
  patient.materials[Structure::liver].young *= 1 + random.unit();
  patient.appearances[Structure::liver].red = random.unit();
  patient.border_cuts[0].normal = Vec3(random.unit(), random.unit(), 1).normalized();
  patient.name = "Tëst \"\\ é 患者";
  patient.attachments[0].reason = "two\nlines";
  return patient;
}

TEST(PatientFile, ReadsBackWhatWasWritten) {
  for (const Patient& patient : {small_patient(), crooked_patient()}) {
    TempFolder folder;
    write_small_patient(folder.path(), patient);
    const Patient again = load_patient(folder.path());
    expect_same(patient, again);
    // A second round changes nothing: hand edits survive any number of saves.
    TempFolder second;
    write_small_patient(second.path(), again);
    EXPECT_EQ(read_bytes(folder / "patient.toml"), read_bytes(second / "patient.toml"));
  }
}

TEST(PatientFile, WritesTheFilesItSaysAndTheSameBytesEachTime) {
  TempFolder a, b;
  const Patient patient = small_patient();
  write_small_patient(a.path(), patient);
  write_small_patient(b.path(), patient);
  std::set<std::string> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(a.path()))
    if (entry.is_regular_file()) found.insert(std::filesystem::relative(entry.path(), a.path()).string());
  const std::vector<std::string> said = patient_files(patient);
  EXPECT_EQ(found, std::set<std::string>(said.begin(), said.end()));
  EXPECT_EQ(said.back(), "patient.toml");
  EXPECT_EQ(said.size(), 9 + patient.materials.size() - 1);
  for (const std::string& name : said) EXPECT_EQ(read_bytes(a / name), read_bytes(b / name)) << name;
}

TEST(PatientFile, ModelLoadsWithMaterialsAndSupports) {
  TempFolder folder;
  const Patient patient = small_patient();
  write_small_patient(folder.path(), patient);
  const Model model = load_model(folder / "model.toml");
  EXPECT_EQ(model.dynamics().time_step, 0.02);
  for (const auto& [s, material] : patient.materials) {
    EXPECT_EQ(model.materials().at(label_of(s)).young, material.young);
    EXPECT_EQ(model.materials().at(label_of(s)).poisson, material.poisson);
    EXPECT_EQ(model.materials().at(label_of(s)).density, material.density);
  }
  std::vector<std::uint8_t> fixed(patient.mesh.vertex_count(), 0);
  for (const Attachment& attachment : patient.attachments)
    if (attachment.kind == AttachmentKind::fixed)
      for (const VertexId v : attachment.vertices) fixed[v.index()] = 1;
  EXPECT_EQ(model.fixed(), fixed);
}

TEST(PatientFile, SurfacesCarryNormalsAndWeights) {
  TempFolder folder;
  const Patient patient = small_patient();
  write_small_patient(folder.path(), patient);
  const Surface surface = read_surface(folder / "surfaces/gallbladder.ply", 1e-3);
  const TexturedSurface wanted =
      textured_surface(patient.mesh, 2, appearance_of(Structure::gallbladder).blend_sharpness);
  ASSERT_EQ(surface.positions.size(), wanted.surface.positions.size());
  EXPECT_EQ(surface.triangles, wanted.surface.triangles);
  for (const std::int32_t region : surface.regions) EXPECT_EQ(region, 2);
  for (std::size_t v = 0; v < surface.positions.size(); ++v)
    expect_near(surface.positions[v], wanted.surface.positions[v], "surface");
  // Another program's reader: lengths of the normals, sums of the weights, volume of the closed surface.
  write_bytes(folder / "read.py", R"(
import numpy as np, sys
head, body = open(sys.argv[1], 'rb').read().split(b'end_header\n', 1)
words = [line.split() for line in head.decode().splitlines()]
n, k = [int(w[2]) for w in words if w[0] == 'element']
kinds = {'double': '<f8', 'float': '<f4'}
v = np.frombuffer(body, np.dtype([(w[2], kinds[w[1]]) for w in words if w[0] == 'property' and w[1] in kinds]), n)
f = np.frombuffer(body, np.dtype([('c', 'u1'), ('v', '<i4', 3), ('region', '<i4')]), k, v.nbytes)
print(v.dtype.names, v.nbytes + f.nbytes == len(body), (f['c'] == 3).all())
stack = lambda names: np.stack([v[i].astype(float) for i in names], 1)
normals, weights, t = stack(['nx', 'ny', 'nz']), stack(['wx', 'wy', 'wz']), stack('xyz')[f['v']]
print(abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-6, abs(weights.sum(1) - 1).max() < 1e-6, weights.min() >= 0)
print(round(np.einsum('ki,ki->k', t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6, 3))
)");
  const CommandResult result = run_command("/usr/bin/python3 '" + (folder / "read.py").string() + "' '" +
                                           (folder / "surfaces/gallbladder.ply").string() + "'");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("('x', 'y', 'z', 'nx', 'ny', 'nz', 'wx', 'wy', 'wz') True True"), std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("True True True"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("\n1500.0"), std::string::npos) << result.output;  // 3 × 2 × 2 cubes of 125 mm³
}

TEST(PatientFile, ProvenanceHoldsHashesThatAnyProgramConfirms) {
  TempFolder folder;
  write_small_patient(folder.path());
  const CommandResult result = run_command("cd '" + folder.path().string() + R"(' && /usr/bin/python3 -c "
import json, hashlib
p = json.load(open('provenance.json'))
print(p['made_by'], p['inputs'][0]['role'], p['steps'][0]['voxels_added'], p['parameters']['tets'], len(p['files']))
print(all(hashlib.sha256(open(n, 'rb').read()).hexdigest() == h for n, h in p['files'].items()))
q = json.load(open('quality.json'))
print(round(q['mesh']['volume_ml'], 6), len(q['regions']))
")");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("calot 9.8.7 CT 12 20000 "), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("\nTrue\n"), std::string::npos) << result.output;
}

// ---- bad input ----

struct Slip {
  std::string from, to, message;
};

/// Replaces the first occurrence; the text must be there.
void exchange(const std::filesystem::path& path, const std::string& from, const std::string& to) {
  std::string text = read_bytes(path);
  const std::size_t place = text.find(from);
  ASSERT_NE(place, std::string::npos) << from;
  write_bytes(path, text.replace(place, from.size(), to));
}

std::size_t line_of(const std::string& text, const std::string& part) {
  const std::size_t place = text.find(part);
  EXPECT_NE(place, std::string::npos) << part;
  return 1 +
         static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n'));
}

TEST(PatientFile, NamesFileLineAndCureOfEveryMistake) {
  const std::vector<Slip> slips{
      {"format = 1 ", "format = 2 ", "format 2 is not one"},
      {"orientation = \"RAS\"", "orientation = \"LPS\"", "orientation must be \"RAS\""},
      {"length_unit = \"mm\"", "length_unit = \"m\"", "length_unit must be \"mm\""},
      {"name = \"liver\"", "name = \"lifer\"", "there is no structure \"lifer\"; did you mean liver?"},
      {"label = 3", "label = 4", "label 4 is not that of cystic duct; write label = 3"},
      {"young = 5400.0", "young = 0", "young = 0 must be > 0 Pa"},
      {"young = 5400.0", "yuong = 5400.0", "unknown key \"yuong\"; did you mean young?"},
      {"poisson = 0.45", "poisson = 0.5", "poisson = 0.5 must lie between -1 and 0.5"},
      {"density = 1060.0", "density = -1", "density = -1 must be > 0 kg/m3"},
      {"density = 1060.0", "density = \"heavy\"", "density must be a number"},
      {"density = 1060.0", "density = nan", "density is not a finite number"},
      {"colour = [0.4,", "colour = [102,", "colour is out of range"},
      {"texture_size = 30.0", "texture_size = 0.03", "texture_size = 0.03 is out of range"},
      {"\nkind = \"fixed\"", "\nkind = \"fix\"", "there is no kind \"fix\"; did you mean fixed?"},
      {"vertices = [\n", "vertices = [\n999999,", "vertex 999999 is not in the mesh; use 0 to "},
      {"vertices = [\n", "vertices = [\n1.5,", "a vertex number must be a whole number"},
      {"axis = \"k\"", "axis = \"z\"", "there is no axis \"z\""},
      {"upper = true", "upper = 1", "upper must be true or false"},
      {"diameter = 10.0", "diameter = 0.01", "diameter = 0.01 is out of range; give 2 to 20 mm"},
      {"purpose = \"laparoscope\"", "porpose = \"laparoscope\"", "unknown key \"porpose\"; did you mean purpose?"},
      {"oblique = 30.0", "oblique = 300", "oblique = 300 is out of range; give 0 to 90 degrees"},
      {"up = [0.0, 0.0, 1.0]", "up = [0, 0, 0]", "up has no direction"},
      {"up = [0.0, 0.0, 1.0]", "up = [0, 8, -5]", "the camera's up points along its view"},
      {"tube = \"cystic duct\"", "tube = \"gallbladder\"", "gallbladder is not a duct or an artery"},
      {"mesh = \"mesh.msh\"", "mesh = \"../mesh.msh\"", "is not a file of this folder"},
      {"mesh = \"mesh.msh\"", "mash = \"mesh.msh\"", "unknown key \"mash\"; did you mean mesh?"},
      {"[camera]", "[camrea]", "unknown key \"camrea\"; did you mean camera?"},
      {"target = [", "target = [1.0, ", "target needs three numbers"},
      {"target = [", "target = [1e9, 0, 0] # ", "target lies more than 10 m away"},
  };
  TempFolder folder;
  write_small_patient(folder.path());
  const std::string whole = read_bytes(folder / "patient.toml");
  for (const Slip& slip : slips) {
    write_bytes(folder / "patient.toml", whole);
    exchange(folder / "patient.toml", slip.from, slip.to);
    const std::string message = message_of([&] { load_patient(folder.path()); });
    EXPECT_NE(message.find(slip.message), std::string::npos) << slip.to << " gave: " << message;
    EXPECT_NE(message.find("patient.toml:"), std::string::npos) << message;
  }
  write_bytes(folder / "patient.toml", whole);
  exchange(folder / "patient.toml", "young = 5400.0", "young = 0");
  EXPECT_NE(message_of([&] {
              load_patient(folder.path());
            }).find("patient.toml:" + std::to_string(line_of(whole, "young = 5400.0")) + ": "),
            std::string::npos);
}

TEST(PatientFile, RefusesWhatIsNoPatient) {
  TempFolder folder;
  EXPECT_NE(message_of([&] { load_patient(folder / "none"); }).find("there is no such folder"), std::string::npos);
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("patient.toml"), std::string::npos);
  write_bytes(folder / "patient.toml", "this is = = no toml");
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("patient.toml:1: not TOML"), std::string::npos);
  write_bytes(folder / "patient.toml", "a = " + std::string(100000, '['));
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("nested too deeply"), std::string::npos);
  std::string dots = "a";
  for (int d = 0; d < 100000; ++d) dots += ".a";
  write_bytes(folder / "patient.toml", dots + " = 1");
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("nested too deeply"), std::string::npos);
}

TEST(PatientFile, RegionsMustBeThoseOfTheMesh) {
  TempFolder folder;
  write_small_patient(folder.path());
  const std::string whole = read_bytes(folder / "patient.toml");
  std::string text = whole;
  const std::size_t start = text.find("[[region]]\nlabel = 8"), end = text.find("# What holds the organs");
  text.erase(start, end - start);
  write_bytes(folder / "patient.toml", text);
  EXPECT_NE(message_of([&] {
              load_patient(folder.path());
            }).find("region 8 (hepatocystic fat) of the mesh has no [[region]]; add one"),
            std::string::npos);
  const std::string more =
      "[[region]]\nlabel = 9\nname = \"gallbladder bed\"\nyoung = 1e3\npoisson = 0.4\ndensity = 1000\n";
  write_bytes(folder / "patient.toml", whole + more);
  EXPECT_NE(message_of([&] {
              load_patient(folder.path());
            }).find(":" + std::to_string(line_of(whole + more, more)) + ": the mesh has no region 9 (gallbladder bed)"),
            std::string::npos)
      << message_of([&] { load_patient(folder.path()); });
  write_bytes(folder / "patient.toml", whole + "[[region]]\nlabel = 1\nname = \"liver\"\n");
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("a second [[region]] for liver, after line "),
            std::string::npos);
}

/// A clip's entry without some of its keys.
std::string without(std::string text, const std::string& entry, const std::vector<std::string>& keys) {
  const std::size_t start = text.find(entry);
  EXPECT_NE(start, std::string::npos);
  for (const std::string& key : keys) {
    const std::size_t line = text.find("\n" + key + " = ", start);
    text.erase(line, text.find('\n', line + 1) - line);
  }
  return text;
}

TEST(PatientFile, WhatAClipDoesntSayComesFromTheCentreline) {
  TempFolder folder;
  const Patient patient = small_patient();
  write_small_patient(folder.path(), patient);
  const std::string whole = read_bytes(folder / "patient.toml"), clip = "name = \"cystic duct, clip 2\"";
  const std::vector<std::vector<std::string>> omissions{
      {"position", "direction", "radius"}, {"arc_length", "direction", "radius"}, {"arc_length"}, {"direction"}};
  for (const auto& keys : omissions) {
    write_bytes(folder / "patient.toml", without(whole, clip, keys));
    expect_same(patient.landmarks, load_patient(folder.path()).landmarks);
  }
  write_bytes(folder / "patient.toml", without(whole, clip, {"arc_length", "position"}));
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("has neither arc_length nor position"),
            std::string::npos);
  write_bytes(folder / "patient.toml", without(whole, "[files]", {"centrelines"}));
  EXPECT_EQ(load_patient(folder.path()).landmarks.clips.size(), 6U);  // whole entries need none
  write_bytes(folder / "patient.toml", without(without(whole, "[files]", {"centrelines"}), clip, {"direction"}));
  EXPECT_NE(message_of([&] { load_patient(folder.path()); }).find("there is no centreline of the cystic duct"),
            std::string::npos);
}

TEST(PatientFile, ThePatientNeedsANameThatCanBeShown) {
  TempFolder folder;
  write_small_patient(folder.path());
  const std::string whole = read_bytes(folder / "patient.toml");
  const std::string line = "name = \"cubes, \\\"small\\\"\"";
  const std::size_t place = whole.find(line);
  ASSERT_NE(place, std::string::npos);
  const std::string where =
      (folder / "patient.toml").string() + ":" +
      std::to_string(1 + std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(place), '\n')) + ": ";
  const auto error_for = [&](const std::string& name) {
    std::string text = whole;
    write_bytes(folder / "patient.toml", text.replace(place, line.size(), "name = " + name));
    return message_of([&] { load_patient(folder.path()); });
  };
  EXPECT_EQ(error_for("\"\"").find(where + "the patient's name is empty; "), 0U) << error_for("\"\"");
  EXPECT_EQ(error_for("\"  \"").find(where + "the patient's name is empty; "), 0U);
  for (const std::string bad : {"\"a\\nb\"", "\"a\\u001bb\"", "\"a\\u007fb\"", "\"a\\u0000b\"", "\"a\tb\""})
    EXPECT_EQ(error_for(bad).find(where + "name = \"a?b\" has control characters; "), 0U) << error_for(bad);
  EXPECT_EQ(error_for("\"Änne Müller\""), "");
}

}  // namespace
