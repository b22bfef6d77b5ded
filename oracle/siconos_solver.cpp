#include "oracle/siconos_solver.h"

#include <siconos/numerics/FrictionContactProblem.h>
#include <siconos/numerics/Friction_cst.h>
#include <siconos/numerics/NonSmoothDrivers.h>
#include <siconos/numerics/NumericsMatrix.h>
#include <siconos/numerics/SolverOptions.h>

#include <cstdlib>

namespace calot::oracle {

SiconosResult solve_with_siconos(const FrictionProblem& problem, const Eigen::VectorXd& start, SiconosMethod method,
                                 double tolerance, int iterations) {
  const int contacts = static_cast<int>(problem.size()), rows = 3 * contacts;
  // Its error mixes motions and forces, so both get the size of forces here. NM_DENSE is column-major as Eigen is.
  const double size = rows > 0 ? problem.delassus.trace() / rows : 1;
  Eigen::MatrixXd w = problem.delassus / size;
  Eigen::VectorXd q = problem.free_motion / size, velocity = Eigen::VectorXd::Zero(rows);
  std::vector<double> friction = problem.friction;
  SiconosResult result;
  result.forces = start.size() == rows ? start : Eigen::VectorXd(Eigen::VectorXd::Zero(rows));

  FrictionContactProblem siconos{};
  siconos.dimension = 3;
  siconos.numberOfContacts = contacts;
  siconos.M = NM_create_from_data(NM_DENSE, rows, rows, w.data());
  siconos.q = q.data();
  siconos.mu = friction.data();
  SolverOptions* options =
      solver_options_create(method == SiconosMethod::newton ? SICONOS_FRICTION_3D_NSN_AC : SICONOS_FRICTION_3D_NSGS);
  options->iparam[SICONOS_IPARAM_MAX_ITER] = iterations;
  options->dparam[SICONOS_DPARAM_TOL] = tolerance;
  result.status = fc3d_driver(&siconos, result.forces.data(), velocity.data(), options);
  result.iterations = options->iparam[SICONOS_IPARAM_ITER_DONE];
  result.error = options->dparam[SICONOS_DPARAM_RESIDU];
  solver_options_delete(options);
  std::free(options);
  NM_clear_not_dense(siconos.M);
  std::free(siconos.M);
  return result;
}

}  // namespace calot::oracle
