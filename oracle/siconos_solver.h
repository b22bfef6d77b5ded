// Siconos as a second opinion on contact with friction: for tests and benchmarks only.
#pragma once
#include "calot/contact/friction.h"

namespace calot::oracle {

enum class SiconosMethod {
  gauss_seidel,  ///< fc3d NSGS
  newton,        ///< fc3d NSN_AC, semi-smooth Newton on the Alart–Curnier function
};

struct SiconosResult {
  Eigen::VectorXd forces;  ///< λ, 3k [N]
  int status = 0;          ///< what fc3d_driver returned; 0: solved
  int iterations = 0;
  double error = 0;  ///< Siconos's own
};

/// Solves the problem with Siconos, to its own tolerance, from `start` (3k, or empty).
SiconosResult solve_with_siconos(const FrictionProblem& problem, const Eigen::VectorXd& start, SiconosMethod method,
                                 double tolerance, int iterations);

}  // namespace calot::oracle
