// The commands of `calot`, one file each. Each function adds its subcommand; the work runs in the subcommand's
// callback, throws calot::Error, and returns normally when done (exit code 0).
#pragma once
#include <CLI/CLI.hpp>

namespace calot {

void add_phantom_command(CLI::App& app);     // phantom_command.cpp
void add_mesh_command(CLI::App& app);        // mesh_command.cpp
void add_patient_command(CLI::App& app);     // patient_command.cpp
void add_precompute_command(CLI::App& app);  // precompute_command.cpp
void add_cut_command(CLI::App& app);         // cut_command.cpp
void add_solve_command(CLI::App& app);       // solve_command.cpp
void add_compare_command(CLI::App& app);     // compare_command.cpp
void add_convert_command(CLI::App& app);     // convert_command.cpp
void add_simulate_command(CLI::App& app);    // simulate_command.cpp
void add_view_command(CLI::App& app);        // view_command.cpp
void add_bench_command(CLI::App& app);       // bench_command.cpp

}  // namespace calot
