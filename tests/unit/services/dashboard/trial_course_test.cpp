#include "services/dashboard/gateway/trial_course.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "services/dashboard/gateway/http_api.hpp"
#include "services/store/memory_store.hpp"
#include "services/store/open_store.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Of the made-up session: 200 Hz, samples from 1000 on, 650 a trial, onset after 240 of them, 5 mm towards
/// 45 deg more each.
json courses_of(const made_up::SessionRecipe& recipe, std::uint32_t attempt) {
  store::MemoryStore store;
  const auto record = made_up::put_session(store, recipe);
  const auto session = store::read_session(store, record.session);
  EXPECT_TRUE(session);
  const auto text = trial_courses(store, *session, attempt);
  EXPECT_TRUE(text) << text.error().message;
  return json::parse(*text);
}

TEST(TrialCourse, IsDisplacementAndForceAboutTheOnsetInTheRigsUnits) {
  const json found = courses_of(made_up::unloaded_session(), 3);  // towards 90 deg: y
  EXPECT_EQ(found["displacement_unit"], "m");
  EXPECT_EQ(found["force_unit"], "N");
  const json& course = found["courses"][0];
  EXPECT_EQ(course["attempt"], 3);
  EXPECT_EQ(course["posture"], "reference");
  EXPECT_EQ(course["missing"], 0);
  const std::vector<double> times = course["times_s"];
  ASSERT_EQ(times.size(), 281U) << "0.2 s before to 1.2 s after, at 200 Hz";
  EXPECT_NEAR(times.front(), -0.2, 1e-9);
  EXPECT_NEAR(times.back(), 1.2, 1e-9);
  const std::size_t onset = 40;
  EXPECT_NEAR(times[onset], 0.0, 1e-9);
  // At rest after the rise: 5 mm along y, and the force K x of the arm in made_up_trial.hpp.
  for (const auto& [name, x, y] :
       {std::tuple{"displacement", 0.0, 0.005}, {"force", 60.0 * 0.005, 210.0 * 0.005}}) {
    const std::vector<double> along_x = course[name][0];
    const std::vector<double> along_y = course[name][1];
    ASSERT_EQ(along_x.size(), times.size());
    EXPECT_NEAR(along_x.back(), x, 1e-6) << name;
    EXPECT_NEAR(along_y.back(), y, 1e-6) << name;
    EXPECT_NEAR(along_x.front(), 0.0, 1e-6) << name;
    EXPECT_NEAR(along_y[onset], 0.0, 1e-6) << name;
  }
}

TEST(TrialCourse, ComesWithTheEightTrialsBeforeItTheNearestFirst) {
  const auto attempts = [](std::uint32_t attempt) {
    std::vector<int> found;
    const json all = courses_of(made_up::unloaded_session(), attempt);
    for (const json& course : all["courses"]) found.push_back(course["attempt"]);
    return found;
  };
  EXPECT_EQ(attempts(12), (std::vector<int>{12, 11, 10, 9, 8, 7, 6, 5, 4}));
  EXPECT_EQ(attempts(3), (std::vector<int>{3, 2, 1}));
  EXPECT_EQ(attempts(1), std::vector<int>{1});
}

TEST(TrialCourse, LeavesOutSamplesThatTheArchiveDoesNotHaveAndCountsThem) {
  auto recipe = made_up::unloaded_session();
  std::uint64_t lost = 0;
  recipe.is_block_lost = [&lost](std::uint64_t first) {  // one block after the first trial's onset
    if (lost == 0 && first > 1250) lost = first;
    return first == lost;
  };
  const json all = courses_of(recipe, 1);
  const json& course = all["courses"][0];
  const auto missing = course["missing"].get<std::size_t>();
  EXPECT_GT(missing, 0U);
  EXPECT_EQ(course["times_s"].size() + missing, 281U);
  for (const json& value : course["force"][0]) EXPECT_TRUE(value.is_number());
}

TEST(TrialCourse, OfATrialThatIsNotThereIsAnErrorThatNamesIt) {
  store::MemoryStore store;
  const auto record = made_up::put_session(store, made_up::unloaded_session());
  const auto session = store::read_session(store, record.session);
  ASSERT_TRUE(session);
  const auto none = trial_courses(store, *session, 99);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(none.error().message, HasSubstr("no trial 99"));
}

TEST(TrialCourse, IsAskedForByHttpUnderItsSession) {
  const ::tonus::testing::TemporaryFolder folder;
  const std::string path = (folder / "archive.sqlite").string();
  std::string session;
  {
    auto store = store::open_store_for_writing(path);
    ASSERT_TRUE(store) << store.error().message;
    session = to_hex(made_up::put_session(**store, made_up::unloaded_session()).session);
  }
  const ApiFolders folders{path, "", ""};
  const auto answer = answer_api(folders, "/api/sessions/" + session + "/courses/2", "");
  EXPECT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(json::parse(answer.body)["courses"].size(), 2U);
  for (const char* attempt : {"", "x", "-1", "2x", "17", "4294967296"})
    EXPECT_EQ(answer_api(folders, "/api/sessions/" + session + "/courses/" + attempt, "").status, 404)
        << attempt;
}

}  // namespace
}  // namespace tonus::dashboard
