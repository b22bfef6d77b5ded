// preview.png of a patient's folder.
#pragma once
#include "calot/patient/patient.h"
#include "calot/picture/picture.h"

namespace calot {

/// One picture to judge a patient by, 1800 pixels wide: the organs from the front with ports and instruments, from the
/// patient's right, and as the laparoscope looks at them, the liver see-through; below, three slices of the CT through
/// Calot's triangle and the gallbladder with the labels' outlines.
Image patient_preview(const Patient& patient, const CompletedAnatomy& anatomy);

}  // namespace calot
