#pragma once

namespace srslam::cli {

/// From now on the first SIGINT or SIGTERM only sets a flag, so that the run can end with
/// everything written; a second one ends the program at once. SIGPIPE is ignored, so that a closed
/// terminal or pipe does not cost the results.
void install_stop_signals();

/// The signal that asked for the end, or 0.
int requested_stop_signal();

}  // namespace srslam::cli
