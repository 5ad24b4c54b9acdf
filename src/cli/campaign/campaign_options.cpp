// The command line of `srslam campaign`.

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "cli/campaign/campaign_command.hpp"

namespace srslam::cli {
namespace {

void add_plan_options(CLI::App* campaign, CampaignSettings* settings) {
  campaign
      ->add_option("--suite", settings->suite,
                   "synthetic, or a folder whose subfolders are sequences in the TUM layout; "
                   "default: that of the plan in the output folder")
      ->type_name("synthetic|FOLDER");
  campaign
      ->add_option("--variants", settings->variants,
                   "baseline, full (every module that is built) or module letters such as SPD, "
                   "separated by commas; default: baseline, and full when a module is built")
      ->type_name("NAMES");
  campaign
      ->add_option("--scenarios", settings->scenarios,
                   "Scenarios of the synthetic suite, separated by commas; default: all")
      ->type_name("NAMES");
  campaign
      ->add_option("--seeds", settings->seeds,
                   "Seeds of the synthetic suite, such as 1,2,3 or 1-4; default: 1")
      ->type_name("SEEDS");
  campaign
      ->add_option("--repeats", settings->num_repeats,
                   "Runs of each variant over each sequence; default: 1")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->type_name("N");
  campaign->add_option("--max-frames", settings->max_frames, "Frames of each sequence, at most")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->type_name("N");
  campaign
      ->add_option("--camera", settings->camera,
                   "Camera preset or camera file of the sequences that have no camera.yaml")
      ->type_name("NAME|FILE");
  campaign
      ->add_option("--config", settings->config_file,
                   "Pipeline options, `key: value` a line, of every run")
      ->type_name("FILE");
}

}  // namespace

CLI::App* add_campaign_command(CLI::App* program, CampaignSettings* settings) {
  CLI::App* campaign = program->add_subcommand(
      "campaign", "Run variants over sequences, each run a process, and make tables of the errors");
  campaign
      ->add_option("--output", settings->output_folder,
                   "Folder of the campaign, made if need be. Given again, only what is not done "
                   "is run")
      ->required()
      ->type_name("DIR");
  add_plan_options(campaign, settings);
  campaign
      ->add_option("--jobs", settings->num_parallel,
                   "Runs at once; each uses 2 threads, and times can be compared with 1 only. "
                   "Default: half the cores")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->type_name("N");
  campaign
      ->add_option("--job-timeout", settings->timeout_s,
                   "A run that takes longer is ended and counted as failed [s]")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->capture_default_str()
      ->type_name("X");
  campaign->add_flag("--retry-failed", settings->retry_failed, "Run failed jobs again");
  campaign->add_flag("--quiet", settings->quiet, "No progress line; warnings remain");
  CLI::Option* plan = campaign->add_flag("--plan", settings->only_plan,
                                         "Print the jobs and write the plan; run nothing");
  CLI::Option* job =
      campaign
          ->add_option("--job", settings->only_job,
                       "Run this job of the plan only; many may run at once, on many machines")
          ->check(CLI::Validator(CLI::PositiveNumber).description(""))
          ->type_name("K");
  CLI::Option* merge = campaign->add_flag("--merge", settings->only_merge,
                                          "Make the tables of what is done; run nothing");
  plan->excludes(job)->excludes(merge);
  job->excludes(merge);
  return campaign;
}

}  // namespace srslam::cli
