#include <gtest/gtest.h>

#include "analysis_service/report/tables.hpp"

namespace tonus::report {
namespace {

study::Study study_of(bool is_simulated) {
  study::Subject subject;
  subject.name = "s01";
  subject.links = {0.3, 0.35};
  if (is_simulated) subject.truth = simulation::SubjectProfile{};
  subject.unloaded = study::SessionAnalysis{};
  study::Study study;
  study.subjects.push_back(std::move(subject));
  study.is_simulated = is_simulated;
  return study;
}

TEST(PublishedValues, StandBesideASimulatedSubjectOfThePaperAndNotBesideAPersonOfTheSameName) {
  const Table simulated = table_one(study_of(true));
  const Table real = table_one(study_of(false));
  ASSERT_EQ(simulated.headings.size(), 8U);
  ASSERT_FALSE(simulated.rows.empty());
  ASSERT_EQ(simulated.rows.size(), real.rows.size());
  const std::string unknown = real.rows[0][2];  // nothing was identified
  for (std::size_t row = 0; row < real.rows.size(); ++row) {
    for (const std::size_t column : {3U, 4U, 6U, 7U}) {
      EXPECT_NE(simulated.rows[row][column], unknown);
      EXPECT_EQ(real.rows[row][column], unknown) << real.headings[column];
    }
  }
}

}  // namespace
}  // namespace tonus::report
