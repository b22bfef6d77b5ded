// What holds the organs.
#pragma once
#include <string>
#include <vector>

#include "calot/patient/completion.h"

namespace calot {

enum class AttachmentKind {
  fixed,       ///< held in place
  peritoneum,  ///< held by a membrane that gives, and that is cut in the operation
};

struct Attachment {
  std::string name;  ///< "liver: bare area", "common bile duct: lower end", "cut face of the CT" …
  AttachmentKind kind = AttachmentKind::fixed;
  std::vector<VertexId> vertices;  ///< ascending, not empty
  std::string reason;
};

/// Finds them on the patient's mesh (regions are Structure numbers):
/// - fixed: the liver's outer vertices far from the operating field (30 mm or more from all other organs; less where
///   the liver is small) that look back and up, where bare area and diaphragm hold it; the ends of ducts and arteries
///   that go on outside of the mesh (an end that joins liver, gallbladder or another tube doesn't); and every outer
///   vertex on a face where the CT's border cut an organ;
/// - peritoneum: where gallbladder, bed and liver meet on the outer surface, the line that the surgeon opens.
/// Every face-connected part of the mesh gets at least three fixed vertices that don't lie on a line: a part of fat,
/// bed or a tube without any is held where it is farthest from the gallbladder. Throws FailedError for a part with
/// gallbladder, cystic duct or liver that nothing holds.
std::vector<Attachment> find_attachments(const TetMesh& mesh, const CompletedAnatomy& anatomy);

}  // namespace calot
