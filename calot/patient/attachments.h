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
  std::string name;    ///< "liver: bare area", "common bile duct: lower end", "cut face of the CT" …
  AttachmentKind kind = AttachmentKind::fixed;
  std::vector<VertexId> vertices;  ///< ascending, not empty
  std::string reason;
};

/// Finds them on the patient's mesh (regions are Structure numbers):
/// - fixed: the liver's outer vertices far from the operating field (at least 30 mm from the gallbladder and its ducts; the
///   side that diaphragm and bare area hold: behind and above), both ends of the bile ducts and the artery that leave
///   the mesh, and every outer vertex on a face where the CT's border cut an organ;
/// - peritoneum: where gallbladder, bed and liver meet on the outer surface, the line that the surgeon opens.
/// Every face-connected part of the mesh gets something fixed. Throws FailedError if one cannot.
std::vector<Attachment> find_attachments(const TetMesh& mesh, const CompletedAnatomy& anatomy);

}  // namespace calot
