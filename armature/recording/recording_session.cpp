#include "armature/recording/recording_session.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "armature/recording/flipbook.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json Header(const Armature& armature, const RecordingOptions& options) {
  json joints = json::array();
  for (const int n : armature.joints)
    joints.push_back(armature.nodes[static_cast<std::size_t>(n)].name);
  return {{"schema", 1}, {"fps", options.fps}, {"step", options.step}, {"joints", joints}};
}

}  // namespace

RecordingSession::RecordingSession(const Armature& armature, const fs::path& folder,
                                   const RecordingOptions& options)
    : armature_(armature), folder_(folder), options_(options) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError(fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
  Lock();
  const fs::path path = folder / "journal.jsonl";
  if (!fs::exists(path) && fs::exists(folder / "curves.json"))
    throw InputError(fmt::format(
        "{} has curves, but no journal: it is a take that was edited, and recording would "
        "replace it; record into another folder",
        folder.string()));
  const std::string text = fs::exists(path) ? ReadFile(path) : "";
  if (!text.empty()) TakeUp(text);
  journal_.fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (journal_.fd < 0)
    throw DiskError(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
  // What a crash left of a line would spoil the next.
  const std::size_t whole = text.rfind('\n') + 1;
  if (was_cut_off_ && ::ftruncate(journal_.fd, static_cast<off_t>(whole)) != 0)
    throw DiskError(fmt::format("cannot cut {}: {}", path.string(), std::strerror(errno)));
  if (whole == 0) Append(Header(armature, options).dump());
  WriteCurves();
}

RecordingSession::OpenFile::~OpenFile() {
  if (fd >= 0) ::close(fd);
}

void RecordingSession::Lock() {
  const fs::path path = folder_ / ".lock";
  lock_.fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_.fd < 0)
    throw DiskError(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
  if (::flock(lock_.fd, LOCK_EX | LOCK_NB) != 0)
    throw LockedError(
        fmt::format("another program records into {}; end it first", folder_.string()));
}

void RecordingSession::TakeUp(const std::string& text) {
  was_cut_off_ = text.back() != '\n';
  std::size_t begin = 0;
  for (int number = 1; begin < text.size(); ++number) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;
    Apply(text.substr(begin, end - begin), number);
    begin = end + 1;
  }
}

void RecordingSession::Apply(const std::string& line, int number) {
  const std::string where =
      fmt::format("{}, line {}", (folder_ / "journal.jsonl").string(), number);
  RequireShallowJson(line, where);
  try {
    const json entry = json::parse(line);
    if (number == 1) {
      if (entry == Header(armature_, options_)) return;
      const auto joints = entry.at("joints").get<std::vector<std::string>>();
      if (const std::string misfit = MisfitOf(joints, armature_); !misfit.empty())
        throw InputError(
            fmt::format("{}: the session {}; else begin another session", where, misfit));
      throw InputError(fmt::format(
          "{}: the session was begun with {} frames a second, step {}; go on with these "
          "(--fps, --step), or begin another session",
          where, entry.at("fps").dump(), entry.at("step").dump()));
    }
    if (entry.contains("record")) {
      const auto frame = entry.at("record").get<std::size_t>();
      const auto values = entry.at("values").get<std::vector<double>>();
      if (frame > frames_.size() || values.size() != armature_.joints.size())
        throw InputError(fmt::format("{}: it does not fit the lines before it", where));
      frames_.resize(std::max(frames_.size(), frame + 1));
      frames_[frame] = values;
      at_ = static_cast<int>(frame) + 1;
    } else if (entry.contains("cut")) {
      frames_.resize(std::min(frames_.size(), entry.at("cut").get<std::size_t>()));
      at_ = frame_count();
    } else {
      at_ = std::clamp(entry.at("at").get<int>(), 0, frame_count());
    }
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: it is damaged: {}", where, JsonFault(error)));
  }
}

void RecordingSession::Append(const std::string& line) {
  const std::string bytes = line + "\n";
  const ssize_t written = ::write(journal_.fd, bytes.data(), bytes.size());
  if (written != static_cast<ssize_t>(bytes.size()) || ::fdatasync(journal_.fd) != 0)
    throw DiskError(fmt::format("cannot write {}: {}; the last frame is not recorded",
                                (folder_ / "journal.jsonl").string(),
                                written < 0 ? std::strerror(errno) : "the disk is full"));
}

void RecordingSession::Record(const std::vector<double>& values) {
  Append(json{{"record", at_}, {"values", values}}.dump());
  frames_.resize(std::max(frames_.size(), static_cast<std::size_t>(at_) + 1));
  frames_[static_cast<std::size_t>(at_)] = values;
  ++at_;
  WriteCurves();
}

void RecordingSession::GoTo(int frame) {
  at_ = std::clamp(frame, 0, frame_count());
  Append(json{{"at", at_}}.dump());
}

void RecordingSession::CutHere() {
  Append(json{{"cut", at_}}.dump());
  frames_.resize(static_cast<std::size_t>(at_));
  WriteCurves();
}

JointCurves RecordingSession::Curves() const {
  JointCurves curves;
  curves.fps = options_.fps;
  curves.step = options_.step;
  for (const int n : armature_.joints)
    curves.joints.push_back(armature_.nodes[static_cast<std::size_t>(n)].name);
  curves.values.resize(frame_count(), static_cast<Eigen::Index>(armature_.joints.size()));
  for (std::size_t f = 0; f < frames_.size(); ++f)
    curves.values.row(static_cast<Eigen::Index>(f)) = Eigen::Map<const Eigen::RowVectorXd>(
        frames_[f].data(), static_cast<Eigen::Index>(frames_[f].size()));
  return curves;
}

void RecordingSession::WriteCurves() const {
  const JointCurves curves = Curves();
  const auto write = [&](const char* name, const std::string& text) {
    // A session that is taken up changes nothing: what was baked of it is as new as it was.
    const fs::path path = folder_ / name;
    if (!fs::is_regular_file(path) || ReadFile(path) != text) WriteFileAtomically(path, text);
  };
  write("curves.json", CurvesJson(armature_, curves));
  write("curves.csv", CurvesCsv(armature_, curves));
  write("curves.bvh", BvhText(CurvesClip(armature_, curves)));
  write("flipbook.json", FlipbookJson(armature_, curves));
  write("flipbook.svg", FlipbookSvg(armature_, curves));
}

}  // namespace keypose::armature
