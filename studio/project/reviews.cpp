#include "studio/project/reviews.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "studio/project/changes.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kLongestNote = 10'000;  // bytes

/// The file's content; that of a project without reviews if there is none.
/// @throws InputError  it cannot be read
json ReviewsIn(const fs::path& project) {
  const fs::path file = project / kReviewsFile;
  if (!fs::exists(file)) return {{"schema", 1}, {"reviews", json::array()}};
  json all = JsonOfFile(file);
  const bool good = all.is_object() && all.value("schema", json()) == 1 &&
                    all.contains("reviews") && all["reviews"].is_array() &&
                    std::all_of(all["reviews"].begin(), all["reviews"].end(), [](const json& one) {
                      return one.is_object() && one.contains("shown") && one["shown"].is_object();
                    });
  if (!good)
    throw InputError(
        fmt::format("{} is not of schema 1, with \"reviews\" that each have \"shown\"; mend it, or "
                    "move it away",
                    kReviewsFile));
  return all;
}

std::string SaidText(const json& review, const char* key) {
  const auto found = review.find(key);
  return found != review.end() && found->is_string() ? found->get<std::string>() : "";
}

void WriteReviews(const fs::path& project, const json& all, const std::string& revision) {
  if (RevisionOf(project / kReviewsFile) != revision)
    throw ChangedMeanwhile("reviews.json was changed elsewhere; it was read again");
  WriteFileAtomically(project / kReviewsFile, all.dump(1) + "\n");
}

json VersionJson(const ResultVersion& version) {
  json files = json::array();
  for (const ResultFile& file : version.files)
    files.push_back(
        {{"path", file.path}, {"title", file.title}, {"film", file.film}, {"at", file.at}});
  return {{"id", version.id},     {"when", version.when}, {"now", version.now},
          {"gone", version.gone}, {"mesh", version.mesh}, {"texture", version.texture},
          {"files", files}};
}

json ReviewJson(const json& review, int index, const ReviewSubject& subject) {
  const auto of = std::find_if(
      subject.versions.begin(), subject.versions.end(),
      [&](const ResultVersion& version) { return json(version.shown) == review["shown"]; });
  const bool found = of != subject.versions.end();
  return {{"index", index},
          {"verdict", SaidText(review, "verdict")},
          {"note", SaidText(review, "note")},
          {"when", SaidText(review, "when")},
          {"holds", found && of->now},
          {"version", found ? of->id : ""}};
}

json SubjectJson(const ReviewSubject& subject, const json& reviews) {
  json versions = json::array(), said = json::array();
  for (const ResultVersion& version : subject.versions) versions.push_back(VersionJson(version));
  for (int i = static_cast<int>(reviews.size()) - 1; i >= 0; --i)
    if (SaidText(reviews[static_cast<std::size_t>(i)], "pose") == subject.pose)
      said.push_back(ReviewJson(reviews[static_cast<std::size_t>(i)], i, subject));
  return {{"pose", subject.pose}, {"versions", versions}, {"reviews", said}};
}

void RequireSayable(const NewReview& review) {
  if (review.verdict != "approved" && review.verdict != "sent back")
    throw UsageError("a result is \"approved\" or \"sent back\"");
  if (review.verdict == "sent back" &&
      review.note.find_first_not_of(" \t\r\n") == std::string::npos)
    throw UsageError("say in a note what is to be changed");
  if (review.note.size() > kLongestNote || !IsValidUtf8(review.note))
    throw UsageError(fmt::format("a note is a text of at most {} bytes", kLongestNote));
}

}  // namespace

json ReviewsJson(Snapshot& snapshot, bool running) {
  std::string problem;
  json reviews = json::array();
  try {
    reviews = ReviewsIn(snapshot.project()).at("reviews");
  } catch (const InputError& error) {
    problem = error.what();
  }
  json subjects = json::array();
  const ResultHistory history(snapshot, running);
  for (const ReviewSubject& subject : history.subjects())
    if (!subject.steps.empty()) subjects.push_back(SubjectJson(subject, reviews));
  return {{"revision", RevisionOf(snapshot.project() / kReviewsFile)},
          {"problem", problem},
          {"running", running},
          {"subjects", subjects}};
}

void AddReview(Snapshot& snapshot, const NewReview& review, const std::string& revision,
               double when, bool running) {
  RequireSayable(review);
  const ResultHistory history(snapshot, running);
  const ResultVersion& version = history.Version(review.pose, review.version);
  if (version.shown.empty())
    throw UsageError("of that result nothing is left to look at; press Run to make it again");
  json steps = json::object();
  for (const pipeline::Step* step : history.Subject(review.pose).steps)
    if (const auto found = version.steps.find(step->id); found != version.steps.end())
      steps[step->rule] = found->second;
  json all = ReviewsIn(snapshot.project());
  json one = {{"verdict", review.verdict},
              {"note", review.note},
              {"when", pipeline::TimeText(when)},
              {"shown", version.shown},
              {"steps", steps}};
  if (!review.pose.empty()) one["pose"] = review.pose;
  all["reviews"].push_back(std::move(one));
  WriteReviews(snapshot.project(), all, revision);
}

void RemoveReview(Snapshot& snapshot, int index, const std::string& revision) {
  json all = ReviewsIn(snapshot.project());
  json& reviews = all["reviews"];
  if (index < 0 || index >= static_cast<int>(reviews.size()))
    throw UsageError("there is no such review");
  reviews.erase(reviews.begin() + index);
  WriteReviews(snapshot.project(), all, revision);
}

void RenameReviewed(const fs::path& project, const std::string& pose, const std::string& to) {
  const std::string revision = RevisionOf(project / kReviewsFile);
  if (revision.empty()) return;
  try {
    json all = ReviewsIn(project);
    for (json& review : all["reviews"])
      if (SaidText(review, "pose") == pose) review["pose"] = to;
    WriteReviews(project, all, revision);
  } catch (const InputError&) {
    // it stays as it is, and the page says what is wrong with it
  }
}

}  // namespace keypose::studio
