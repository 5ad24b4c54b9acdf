#include "cli/report/campaign_report.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "cli/campaign/campaign_table_text.hpp"
#include "cli/gnuplot.hpp"
#include "cli/number_text.hpp"
#include "cli/report/html_text.hpp"
#include "cli/run_outputs.hpp"

namespace srslam::cli {
namespace {

constexpr const char* kError = "ate_rmse_m";
constexpr const char* kChartName = "errors.svg";
constexpr std::array<const char*, 8> kColors = {"#7f7f7f", "#1f4e9c", "#e08214", "#2a8a57",
                                                "#b2377a", "#6a51a3", "#8c6d31", "#3fa7c4"};

/// Smallest and largest error of the chart; both 0 when there is none.
std::pair<double, double> error_range(const CampaignTables& tables) {
  std::pair<double, double> range = {0.0, 0.0};
  bool first = true;
  for (const std::vector<CampaignCell>& row : tables.cells) {
    for (const CampaignCell& cell : row) {
      const CampaignAggregate* figure = cell.find(kError);
      if (figure == nullptr) continue;
      range.first = first ? figure->min : std::min(range.first, figure->min);
      range.second = std::max(range.second, figure->max);
      first = false;
    }
  }
  return range;
}

std::string number_or_nothing(const std::map<std::string, double>& figures, const std::string& key,
                              int num_decimals) {
  const auto found = figures.find(key);
  return found == figures.end() ? std::string() : fixed_text(found->second, num_decimals);
}

std::string chart_html(const CampaignPlan& plan, const CampaignTables& tables,
                       const std::string& folder) {
  std::string html = "<h2>Absolute error by sequence and variant</h2>\n";
  const std::string script = error_chart_script(plan, tables, kChartName);
  if (script.empty()) return html + "<p>No job has an absolute error.</p>\n";
  std::vector<std::string> pictures;
  const FileStatus drawn = run_gnuplot(script, folder, "chart", {kChartName}, &pictures);
  if (!drawn.ok()) {
    return html + "<p>There is no chart: " + html_text(drawn.reason) +
           ". The tables have the figures.</p>\n";
  }
  return html + "<div style=\"max-width:60rem\">" +
         html_picture("image/svg+xml", pictures.front(), "absolute errors",
                      "ATE RMSE: median, smallest and largest over repeats and seeds") +
         "</div>\n";
}

}  // namespace

std::string error_chart_script(const CampaignPlan& plan, const CampaignTables& tables,
                               const std::string& name) {
  const auto [min_m, max_m] = error_range(tables);
  const std::size_t num_variants = plan.variants.size();
  std::string blocks;
  std::string plots;
  for (std::size_t v = 0; v < num_variants; ++v) {
    std::string rows;
    for (std::size_t r = 0; r < tables.rows.size(); ++r) {
      const CampaignAggregate* figure = tables.cells[r][v].find(kError);
      if (figure == nullptr) continue;
      // Variants of a row lie one below the other.
      const double offset =
          0.7 * ((static_cast<double>(v) + 0.5) / static_cast<double>(num_variants) - 0.5);
      rows += shortest_text(figure->median) + " " + shortest_text(static_cast<double>(r) + offset) +
              " " + shortest_text(figure->min) + " " + shortest_text(figure->max) + "\n";
    }
    if (rows.empty()) continue;
    std::string block = "$variant";
    block += std::to_string(v);
    blocks += block;
    blocks += " << END_OF_DATA\n";
    blocks += rows;
    blocks += "END_OF_DATA\n";
    plots += plots.empty() ? "plot " : ", ";
    plots += block;
    plots += " using 1:2:3:4 with xerrorbars pt 7 ps 0.7 lw 1.6 lc rgb '";
    plots += kColors[v % kColors.size()];
    plots += "' title " + gnuplot_quoted(plan.variants[v].name);
  }
  if (plots.empty()) return {};
  constexpr int kWidth_px = 520;
  constexpr int kFrame_px = 120;
  const int row_px = 14 + 12 * static_cast<int>(num_variants);
  const int height_px = kFrame_px + row_px * static_cast<int>(tables.rows.size());
  std::string script = gnuplot_picture(PlotFormat::kSvg, kWidth_px, height_px, name) + blocks;
  // Errors of sequences differ by powers of ten, and so do good and bad variants.
  constexpr double kLogarithmicRatio = 20.0;
  if (min_m > 0.0 && max_m > kLogarithmicRatio * min_m) {
    script += "set logscale x\nset xrange [" + shortest_text(0.7 * min_m) + ":" +
              shortest_text(1.4 * max_m) + "]\n";
  } else {
    script += "set xrange [0:" + shortest_text(max_m > 0.0 ? 1.08 * max_m : 1.0) + "]\n";
  }
  script += "set yrange [" + shortest_text(static_cast<double>(tables.rows.size()) - 0.4) +
            ":-0.6]\nset xlabel 'ATE RMSE [m]'\nset ytics (";
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    script += (r == 0 ? "" : ", ") + gnuplot_quoted(tables.rows[r]) + " " + std::to_string(r);
  }
  script += ")\nset key outside top center horizontal samplen 1\n";
  return script + plots + "\nset output\n";
}

TextTable job_table(const CampaignPlan& plan, const std::vector<JobRecord>& records) {
  TextTable table;
  table.title = "Jobs";
  table.header = {"Job",     "Sequence", "Seed",     "Variant",  "Repeat",      "State",
                  "ATE [m]", "Coverage", "Wall [s]", "Frames/s", "Jobs at once"};
  const std::vector<CampaignJob> jobs = plan_jobs(plan);
  for (std::size_t i = 0; i < jobs.size() && i < records.size(); ++i) {
    const CampaignJob& job = jobs[i];
    const JobRecord& record = records[i];
    const CampaignSequence& sequence = plan.sequences[job.sequence];
    const bool is_done = record.status == JobStatus::kDone;
    TextTable::Field number(std::to_string(job.index));
    if (is_done) {
      number.link = std::string(kJobsFolder) + "/" + job.id + "/" + kReportFile;
    }
    const char* state = record.status == JobStatus::kFailed ? "failed" : "missing";
    table.rows.push_back(
        {number, sequence.name, sequence.seed ? std::to_string(*sequence.seed) : std::string(),
         plan.variants[job.variant].name, std::to_string(job.repeat),
         std::string(is_done ? "done" : state), number_or_nothing(record.figures, kError, 4),
         number_or_nothing(record.figures, "coverage_with_depth", 4),
         number_or_nothing(record.times, "wall_s", 2),
         number_or_nothing(record.times, "frames_per_s", 1),
         is_done ? std::to_string(record.num_parallel) : std::string()});
  }
  return table;
}

std::string campaign_report_page(const CampaignPlan& plan, const CampaignTables& tables,
                                 const std::vector<JobRecord>& records, const std::string& folder) {
  std::string body = "<ul>\n";
  for (const std::string& line : table_statements(plan, tables)) {
    body += "<li>" + html_text(line) + "</li>\n";
  }
  body += "</ul>\n";
  // What went wrong comes first: the figures below are without it.
  for (const TextTable& table : {failed_table(tables), missing_table(tables)}) {
    if (!table.rows.empty()) body += html_table(table);
  }
  body += chart_html(plan, tables, folder);
  for (const TextTable& table : campaign_text_tables(plan, tables)) body += html_table(table);
  body += html_table(job_table(plan, records));
  body +=
      "<p>Times depend on the machine and on what else ran: compare them between runs with one job "
      "at once only.</p>\n";
  return html_page("srslam campaign: " + plan.suite, body);
}

}  // namespace srslam::cli
