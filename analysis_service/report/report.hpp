#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "analysis_service/study/study.hpp"

namespace tonus::report {

/// Writes the report into `folder`, which is made: index.html with every table and figure, each table as CSV,
/// each figure as SVG and PDF beside its data and its gnuplot script. The same study gives the same bytes.
/// `progress` is told what is being drawn. Errors: kIo; kUnavailable where gnuplot is missing or refuses a
/// script, with its first line.
[[nodiscard]] Result<void> write_report(const study::Study& study, const std::filesystem::path& folder,
                                        const std::function<void(const std::string&)>& progress);

}  // namespace tonus::report
