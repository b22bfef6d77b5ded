// What the simulation's benchmarks measure, at any size: the benchmarks call it with theirs, the tests with small ones.
#pragma once
#include "bench/operation.h"

namespace calot::bench {

/// Steps at full speed until the grasper holds and the tubes press. Throws FailedError if it doesn't hold then.
void warm_up(Operation& operation);
/// Throws FailedError unless the grasper still holds: something else was measured then.
void check_hold(const Operation& operation);
/// "10239 tets, body 20 kPa, ducts 500 kPa".
std::string words_of(const Organ& organ, const Stiffness& stiffness);
std::vector<double> milliseconds(std::vector<double> seconds);

/// NAME: a step without waiting; NAME.frame: with it; NAME.PHASE; late frames; iterations; residuals.
/// @param goal_ms  for the step; ≤ 0: none
std::vector<Row> paced_rows(const std::string& name, const PacedRun& run, double goal_ms);

std::vector<Row> step_rows(const std::string& name, const Organ& organ, const Stiffness& stiffness, double goal_ms,
                           std::size_t steps);
/// Friction problems of a running operation, ours and Siconos's answers, and what finding the contacts costs.
std::vector<Row> contact_rows(const Organ& organ, std::size_t problems);
/// Transections of the duct by scissors while everything goes on.
std::vector<Row> cut_rows(const Organ& organ, const std::vector<double>& shares);
/// Pictures of an operation, the world's pace beside them, and how long a motion of the hand takes to be seen.
std::vector<Row> view_rows(const Organ& organ, const Organ& small, std::size_t pictures, std::size_t steps);
/// The haptic loop on a running operation.
std::vector<Row> haptic_rows(const Organ& organ, double seconds);

}  // namespace calot::bench
