#include "cli/campaign/campaign_plan.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "cli/campaign/campaign_command.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::cli {
namespace {

using srslam::test::TempFolder;
using srslam::test::tiny_camera;
using srslam::test::write_text;
using testing::Test;

const std::vector<Module> kAllBuilt = {
    {'S', "s", true, ""}, {'P', "p", true, "S"}, {'D', "d", true, "S"}, {'B', "b", true, "S"}};
const std::vector<Module> kNoneBuilt = {{'S', "scene", false, ""}, {'P', "pose", false, "S"}};

std::vector<std::string> modules_of(const std::vector<CampaignVariant>& variants) {
  std::vector<std::string> modules;
  modules.reserve(variants.size());
  for (const CampaignVariant& variant : variants) {
    modules.push_back(variant.name + "=" + variant.modules);
  }
  return modules;
}

TEST(CampaignVariants, AreNamesForModules) {
  std::vector<CampaignVariant> variants;
  EXPECT_EQ(parse_variants("baseline,S,SP,SPD,SD, full", kAllBuilt, &variants), "");
  EXPECT_EQ(modules_of(variants),
            (std::vector<std::string>{"baseline=none", "S=S", "SP=S,P", "SPD=S,P,D", "SD=S,D",
                                      "full=S,P,D,B"}));
  EXPECT_EQ(parse_variants("", kAllBuilt, &variants), "");
  EXPECT_EQ(modules_of(variants), (std::vector<std::string>{"baseline=none", "full=S,P,D,B"}));
  EXPECT_EQ(parse_variants("", kNoneBuilt, &variants), "");
  EXPECT_EQ(modules_of(variants), (std::vector<std::string>{"baseline=none"}));
}

TEST(CampaignVariants, RefusesWhatCannotRunOrIsTwice) {
  std::vector<CampaignVariant> variants;
  const auto reason = [&](const std::string& text, const std::vector<Module>& modules) {
    return parse_variants(text, modules, &variants);
  };
  EXPECT_NE(reason("S", kNoneBuilt).find("not built in this version"), std::string::npos);
  EXPECT_NE(reason("full", kNoneBuilt).find("variant 'full': no module is built"),
            std::string::npos);
  EXPECT_NE(reason("baseline,X", kAllBuilt).find("variant 'X': unknown module 'X'"),
            std::string::npos);
  EXPECT_NE(reason("PD", kAllBuilt).find("needs module 'S'"), std::string::npos);
  EXPECT_NE(reason("SPD,SDP", kAllBuilt).find("'SPD' and 'SDP' are the same modules: S,P,D"),
            std::string::npos);
  EXPECT_NE(reason("baseline,", kAllBuilt), "");
  EXPECT_TRUE(variants.empty());
}

TEST(CampaignSeeds, AreNumbersAndRanges) {
  std::vector<std::uint32_t> seeds;
  EXPECT_EQ(parse_seeds("3, 1,7-9", &seeds), "");
  EXPECT_EQ(seeds, (std::vector<std::uint32_t>{3, 1, 7, 8, 9}));
  EXPECT_EQ(parse_seeds("4294967295", &seeds), "");
  for (const char* text : {"", "a", "1,", "-1", "2-1", "1-", "1.5", "4294967296", "0-4294967295"}) {
    EXPECT_NE(parse_seeds(text, &seeds), "") << text;
  }
  EXPECT_EQ(parse_seeds("1-3,2", &seeds), "seed 2 is given twice");
  EXPECT_EQ(seeds, (std::vector<std::uint32_t>{4294967295U})) << "set on success only";
}

CampaignPlan plan_of_folders() {
  CampaignPlan plan;
  plan.version = "0.1.0";
  plan.suite = "/data";
  plan.sequences = {{"desk", std::nullopt, "/data/desk", ""},
                    {"a b/$x", std::nullopt, "/data/a b$x", "tum_fr1"}};
  plan.variants = {{"baseline", "none"}, {"SP", "S,P"}};
  plan.num_repeats = 2;
  plan.max_frames = 50;
  plan.config_hash = "0123";
  return plan;
}

TEST(CampaignPlan, NumbersItsJobsAndNamesThem) {
  const std::vector<CampaignJob> jobs = plan_jobs(plan_of_folders());
  ASSERT_EQ(jobs.size(), 8U);
  EXPECT_EQ(jobs[0].id, "001_desk_baseline_r1");
  EXPECT_EQ(jobs[3].id, "004_desk_SP_r2");
  EXPECT_EQ(jobs[7].id, "008_a_b__x_SP_r2");
  EXPECT_EQ(jobs[7].index, 8U);
  EXPECT_EQ(jobs[7].sequence, 1U);
  EXPECT_EQ(jobs[7].variant, 1U);
  EXPECT_EQ(jobs[7].repeat, 2U);
  std::set<std::string> ids;
  for (const CampaignJob& job : jobs) ids.insert(job.id);
  EXPECT_EQ(ids.size(), jobs.size());
}

TEST(CampaignPlan, PrintsCommandsThatAShellTakes) {
  const std::string text = job_list_text(plan_of_folders(), "/out");
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "1\t001_desk_baseline_r1\tsrslam run --dataset /data/desk --modules none --config "
            "/out/config.yaml --output /out/jobs/001_desk_baseline_r1 --quiet --max-frames 50");
  EXPECT_NE(text.find("--dataset '/data/a b$x' --modules S,P"), std::string::npos);
  EXPECT_NE(text.find("--camera tum_fr1"), std::string::npos);
}

TEST(CampaignPlan, ComesBackFromItsFile) {
  CampaignPlan plan = plan_of_folders();
  plan.sequences[0].seed = 7;
  plan.max_frames.reset();
  CampaignPlan read;
  EXPECT_EQ(parse_plan(plan_json(plan).dump(), "plan.json", &read), "");
  EXPECT_EQ(plan_json(read), plan_json(plan));
  EXPECT_EQ(plan_difference(plan, read), "");
  EXPECT_TRUE(read.sequences[0].is_rendered());
  EXPECT_EQ(sequence_folder(read.sequences[0], "/out"), "/data/desk") << "absolute as it is";
}

TEST(CampaignPlan, RefusesADamagedFile) {
  CampaignPlan plan;
  const std::string good = plan_json(plan_of_folders()).dump();
  for (const std::string& text : {std::string(), std::string("[]"), good.substr(0, good.size() / 2),
                                  std::string("{\"format\": 2}")}) {
    EXPECT_NE(parse_plan(text, "plan.json", &plan).find("plan.json: "), std::string::npos) << text;
  }
  for (const char* key :
       {"version", "suite", "repeats", "max_frames", "config_hash", "variants", "sequences"}) {
    nlohmann::ordered_json json = plan_json(plan_of_folders());
    json[key] = true;
    EXPECT_NE(parse_plan(json.dump(), "plan.json", &plan).find(key), std::string::npos);
    json.erase(key);
    EXPECT_NE(parse_plan(json.dump(), "plan.json", &plan).find(key), std::string::npos);
  }
}

TEST(CampaignPlan, SaysWhatDiffers) {
  CampaignPlan other = plan_of_folders();
  other.num_repeats = 3;
  other.variants.pop_back();
  EXPECT_EQ(plan_difference(plan_of_folders(), other),
            "repeats: 2 there, 3 now; variants: only there "
            "[{\"name\":\"SP\",\"modules\":\"S,P\"}]");
  other = plan_of_folders();
  std::swap(other.sequences[0], other.sequences[1]);
  EXPECT_EQ(plan_difference(plan_of_folders(), other), "sequences: in another order");
}

class CampaignSuite : public Test {
 protected:
  std::string add_sequence(const std::string& name, bool with_camera) const {
    write_text(folder_ / (name + "/rgb.txt"), "# empty\n");
    if (with_camera) {
      EXPECT_TRUE(write_camera_file(folder_ / (name + "/camera.yaml"), tiny_camera()).ok());
    }
    return folder_ / name;
  }

  TempFolder folder_;
  std::vector<CampaignSequence> sequences_;
};

TEST_F(CampaignSuite, IsEverySubfolderWithImagesByName) {
  add_sequence("b", true);
  add_sequence("a", true);
  write_text(folder_ / "c/notes.txt", "no images\n");
  ASSERT_EQ(find_sequences(folder_.path(), "tum_fr1", &sequences_), "");
  ASSERT_EQ(sequences_.size(), 2U);
  EXPECT_EQ(sequences_[0].name, "a");
  EXPECT_EQ(sequences_[1].name, "b");
  EXPECT_EQ(sequences_[0].camera, "") << "its own camera comes first";
  ASSERT_EQ(find_sequences(folder_ / "b/", "", &sequences_), "");
  ASSERT_EQ(sequences_.size(), 1U);
  EXPECT_EQ(sequences_[0].name, "b");
}

TEST_F(CampaignSuite, NamesEverySequenceWithoutACamera) {
  add_sequence("a", false);
  add_sequence("b", true);
  add_sequence("c", false);
  write_text(add_sequence("d", false) + "/camera.yaml", "width_px: 3\n");
  const std::string reason = find_sequences(folder_.path(), "", &sequences_);
  for (const char* part : {"/a has no camera.yaml: give --camera", "/c has no", "/d/camera.yaml"}) {
    EXPECT_NE(reason.find(part), std::string::npos) << reason;
  }
  EXPECT_EQ(reason.find("/b"), std::string::npos) << reason;
  std::filesystem::remove_all(folder_ / "d");
  ASSERT_EQ(find_sequences(folder_.path(), "tum_fr3", &sequences_), "");
  EXPECT_EQ(sequences_[0].camera, "tum_fr3");
}

TEST_F(CampaignSuite, RefusesAFolderWithoutSequences) {
  EXPECT_NE(find_sequences(folder_.path(), "", &sequences_).find("rgb.txt"), std::string::npos);
  EXPECT_NE(find_sequences(folder_ / "absent", "", &sequences_).find("neither synthetic nor"),
            std::string::npos);
}

TEST(CampaignRendering, IsPlannedForEveryScenarioAndSeed) {
  const SequenceRenderer renderer = synthetic_renderer("/bin/srslam");
  EXPECT_EQ(renderer.scenarios.size(), 18U);
  std::vector<CampaignSequence> sequences;
  ASSERT_EQ(rendered_sequences(renderer, "crowd,occlusion", {4, 2}, &sequences), "");
  ASSERT_EQ(sequences.size(), 4U);
  EXPECT_EQ(sequences[1].label(), "crowd_seed2");
  EXPECT_EQ(sequence_folder(sequences[1], "/out"), "/out/sequences/crowd_seed2");
  EXPECT_NE(rendered_sequences(renderer, "crowd,none", {1}, &sequences), "");
  EXPECT_NE(rendered_sequences(renderer, "crowd,crowd", {1}, &sequences), "");
  RenderRequest request;
  request.scenario = "crowd";
  request.seed = 2;
  request.max_frames = 10;
  request.folder = "x";
  EXPECT_EQ(renderer.command(request),
            (std::vector<std::string>{"/bin/srslam", "synth", "--scenario", "crowd", "--output",
                                      "x", "--seed", "2", "--frames", "10"}));
}

TEST(CampaignRendering, TakesNoCameraAndNoSeedsForAFolder) {
  CampaignPlan plan;
  std::string config;
  CampaignSettings settings;
  settings.suite = "synthetic";
  settings.camera = "tum_fr1";
  const SequenceRenderer renderer = synthetic_renderer("srslam");
  EXPECT_NE(make_plan(settings, renderer, &plan, &config).find("--camera"), std::string::npos);
  settings = {};
  settings.suite = "/";
  settings.seeds = "1";
  EXPECT_NE(make_plan(settings, renderer, &plan, &config).find("--seeds is for"),
            std::string::npos);
  settings = {};
  settings.suite = "synthetic";
  settings.config_file = "/absent.yaml";
  EXPECT_NE(make_plan(settings, renderer, &plan, &config).find("/absent.yaml"), std::string::npos);
}

}  // namespace
}  // namespace srslam::cli
