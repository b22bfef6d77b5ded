// Everything the library's users need, in one include.
#pragma once
#include "calot/base/error.h"
#include "calot/base/parallel.h"
#include "calot/compliance/compliance.h"
#include "calot/compliance/compliance_file.h"
#include "calot/cut/cut.h"
#include "calot/fem/model.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"
