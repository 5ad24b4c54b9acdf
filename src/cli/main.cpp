#include "cli/program.hpp"

int main(int argc, char** argv) { return srslam::cli::run_program(argc, argv); }
