// `keypose armature live`: the character, posed by the armature while it is moved.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>
#include <utility>

#include "armature/armature_commands.h"
#include "armature/example/theropod.h"
#include "armature/live/latency.h"
#include "armature/live/page_stream.h"
#include "armature/live/picture_writer.h"
#include "armature/live/pose_text.h"
#include "armature/live/posed_puppet.h"
#include "armature/live/puppet_files.h"
#include "armature/puppet.h"
#include "armature/recording/recording_session.h"
#include "armature/recording/still_joints.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

using nlohmann::json;
using LiveClock = std::chrono::steady_clock;

/// While the puppet stands the page still hears how the controller does.
constexpr double kPageHeartbeat_s = 0.5;

struct LiveFlags {
  PuppetFlags puppet;
  PuppetPaths paths;
  PuppetChoices choices;
  RecordingOptions session_options;
  std::string session, pictures, plate, shot, set, texture, page, simulated = "walk";
  double rate = 200, seconds = 0, picture_rate = 6, page_rate = 30;
  int onion = 1;
  bool quiet = false;
};

double LiveSeconds(LiveClock::time_point a, LiveClock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

/// All of a live session: what comes from the armature, what is typed, what is written.
class LiveSession {
 public:
  LiveSession(const LiveFlags& flags, LoadedPuppet loaded, Puppet& reader)
      : flags_(flags),
        parts_(std::move(loaded.parts)),
        reader_(reader),
        posed_(parts_),
        plates_(flags.plate, flags.shot, parts_.mesh.points),
        walks_(reader.simulated() && flags.simulated == "walk") {
    if (!flags.texture.empty()) texture_ = ReadImage(flags.texture, 3);
    if (!flags.set.empty()) set_ = ReadMesh(flags.set);
    if (!flags.pictures.empty())
      pictures_ = std::make_unique<PictureWriter>(look_, plates_, flags.pictures);
    if (!flags.session.empty())
      session_ =
          std::make_unique<RecordingSession>(parts_.armature, flags.session, flags.session_options);
    if (!flags.page.empty())
      page_ = std::make_unique<PageStream>(parts_, plates_, !flags.paths.mesh.empty(), flags.page);
    if (session_) TakeUpSession();
    begin_ = LiveClock::now();
    processor_begin_ = ProcessorSeconds();
  }

  /// Reads, poses and tells once.
  void Step() {
    const auto begin = LiveClock::now();
    MoveSimulated(begin);
    const Reading& reading = reader_.Poll();
    const double read_s = LiveSeconds(begin, LiveClock::now());
    posed_.Update(reading.values);
    const double whole_s = LiveSeconds(begin, LiveClock::now());
    read_.Add(read_s);
    match_.Add(posed_.match_s());
    skin_.Add(posed_.skin_s());
    pose_.Add(whole_s - read_s);
    whole_.Add(whole_s);
    TellReader();
    if (page_) TellPage(begin, reading);
    if (posed_.matcher().moved() || number_ == 0) {
      if (!flags_.quiet && !page_)
        Print(PoseJson(parts_.skeleton, posed_.matcher(),
                       {LiveSeconds(begin_, begin), number_, reading.fresh, whole_s}));
      wants_picture_ = true;
    }
    ++number_;
    if (wants_frame_) TryToRecord(reading);
    if (wants_picture_) OfferPicture(begin);
  }

  /// @return false: the session shall end
  bool Do(const std::string& line) {
    std::istringstream words(line);
    std::string word, which;
    words >> word;
    if (word == "end" || word == "quit") return false;
    if (word == "plate" && words >> which) return GoToPlate(which);
    if (!session_) return Refuse("without --session there is only: plate N, plate next, end");
    if (word.empty() || word == "record") {
      told_waiting_ = false;
      return wants_frame_ = true;
    }
    wants_frame_ = false;
    if (word == "next") return GoTo(session_->at() + 1);
    if (word == "back") return GoTo(session_->at() - 1);
    if (int frame = 0; word == "goto" && words >> frame) return GoTo(frame);
    if (word == "cut") {
      session_->CutHere();
      told_still_.clear();
      return GoTo(session_->at());
    }
    if (word == "zero" && words >> which) return SetToZero(which);
    return Refuse("'" + line + "' is not understood; type record, next, back, goto N, cut, " +
                  "zero JOINT, plate N, plate next or end");
  }

  void TellMissed() { ++missed_; }

  void Finish() {
    if (pictures_) {
      // The last pose is always shown.
      pictures_->Finish();
      if (wants_picture_) OfferPicture(LiveClock::time_point::max());
      pictures_->Finish();
    }
    TellStatistics();
  }

 private:
  bool Refuse(const std::string& words) {
    Say(json{{"event", "refused"}, {"words", words}});
    return true;
  }

  void Say(const json& event) { Print(event.dump(-1, ' ', false, json::error_handler_t::replace)); }

  void Print(const std::string& line) {
    std::fputs((line + "\n").c_str(), stdout);
    std::fflush(stdout);
  }

  /// The simulated puppet walks, or takes the pose of the frame that is next.
  void MoveSimulated(LiveClock::time_point now) {
    if (!reader_.simulated()) return;
    if (walks_)
      return reader_.simulated()->MoveTo(ExampleMotion(parts_.armature, LiveSeconds(begin_, now)));
    if (posed_for_ == session_->at()) return;
    posed_for_ = session_->at();
    reader_.simulated()->BeginFrame(posed_for_);
    const RecordingOptions& film = flags_.session_options;
    reader_.simulated()->MoveTo(ExampleMotion(parts_.armature, posed_for_ * film.step / film.fps));
  }

  void TellReader() {
    for (const ReaderEvent& event : reader_.reader().TakeEvents()) {
      json told{{"event", event.code}, {"words", event.words}, {"what_to_do", event.what_to_do}};
      if (event.joint >= 0) told["joint"] = reader_.JointName(event.joint);
      Say(told);
    }
  }

  /// A line for the page: at its rate while something moves, else now and then.
  void TellPage(LiveClock::time_point now, const Reading& reading) {
    CountWraps();
    page_moved_ = page_moved_ || posed_.matcher().moved();
    const double wait_s = page_moved_ ? 1 / flags_.page_rate : kPageHeartbeat_s;
    if (number_ > 0 && LiveSeconds(page_at_, now) < wait_s) return;
    page_at_ = now;
    page_moved_ = false;
    Print(page_->Line(posed_.matcher(),
                      {LiveSeconds(begin_, now), reading.fresh, reading.values, reading.held,
                       wraps_, reader_.reader().repeats(), reader_.reader().damaged()}));
  }

  /// A counter of 24 bits that passes its end. One that is 0 where its joint is passes it with its
  /// joint's zero, which is no news.
  void CountWraps() {
    const std::vector<SensorState>& states = reader_.reader().tracker().states();
    raw_.resize(states.size(), 0);
    wraps_.resize(states.size(), 0);
    for (std::size_t j = 0; j < states.size(); ++j) {
      const bool at_zero = (states[j].counts & 0xFFFFFF) == states[j].raw;
      if (number_ > 0 && !at_zero && std::abs(states[j].raw - raw_[j]) > (1 << 23)) ++wraps_[j];
      raw_[j] = states[j].raw;
    }
  }

  bool SetToZero(const std::string& joint) {
    try {
      reader_.SetJoint(joint, 0);
    } catch (const UsageError& error) {
      return Refuse(error.what());
    }
    told_still_.erase(static_cast<int>(reader_.JointNamed(joint)));
    Say(json{{"event", "set"}, {"joint", joint}, {"words", joint + " stands at 0 now"}});
    return true;
  }

  void OfferPicture(LiveClock::time_point now) {
    if (!pictures_) return;
    const bool last = now == LiveClock::time_point::max();
    if (!last && LiveSeconds(picture_at_, now) < 1 / flags_.picture_rate) return;
    const std::string name = pictures_->Offer(posed_.points(), plate_, ghosts_);
    if (name.empty()) return;
    wants_picture_ = false;
    picture_at_ = now;
    Say(json{{"event", "picture"}, {"file", name}, {"plate", plate_}, {"pose", number_}});
  }

  bool GoToPlate(const std::string& which) {
    int plate = plate_ + 1;
    if (which != "next" && std::sscanf(which.c_str(), "%d", &plate) != 1)
      return Refuse("plate '" + which + "' is not a number");
    if (plate < 0 || plate >= plates_.count())
      return Refuse(
          fmt::format("there is no plate {}; the shot had {} when the session began: begin "
                      "it again to see later ones",
                      plate, plates_.count()));
    plate_ = plate;
    wants_picture_ = true;
    Say(json{{"event", "plate"}, {"plate", plate_}});
    return true;
  }

  /// The frame is taken as soon as all sensors are read and the puppet is at rest; one that walks
  /// by itself is taken as it is.
  void TryToRecord(const Reading& reading) {
    const std::string obstacle = reader_.Obstacle(reading, walks_);
    if (!obstacle.empty()) {
      if (obstacle != kPuppetMoves && !std::exchange(told_waiting_, true))
        Say(json{{"event", "waiting"}, {"words", obstacle}});
      return;
    }
    wants_frame_ = false;
    const int frame = session_->at();
    session_->Record(reading.values);
    if (page_) page_->Record(frame, posed_.matcher().pose());
    reader_.SaveCalibration();
    AddGhost(posed_.points());
    Say(json{{"event", "recorded"}, {"frame", frame}, {"frames", session_->frame_count()}});
    TellStill();
    FollowPlate();
  }

  void TellStill() {
    const auto end = session_->frames().begin() + session_->at();
    for (const int joint : StillJoints(parts_.armature, {session_->frames().begin(), end}))
      if (told_still_.insert(joint).second)
        Say(json{{"event", "still-joint"},
                 {"joint", reader_.JointName(joint)},
                 {"since", session_->at() - 3},
                 {"words", StillWords(reader_.JointName(joint), session_->at() - 3)}});
  }

  /// What was recorded before this program began.
  void TakeUpSession() {
    TakeUpGhosts();
    if (page_) page_->TakeUp(session_->frames());
    Say(json{{"event", "session"},
             {"at", session_->at()},
             {"frames", session_->frame_count()},
             {"fps", flags_.session_options.fps},
             {"step", flags_.session_options.step},
             {"cut_off", session_->was_cut_off()}});
    FollowPlate();
  }

  bool GoTo(int frame) {
    session_->GoTo(frame);
    TakeUpGhosts();
    Say(json{{"event", "at"}, {"at", session_->at()}, {"frames", session_->frame_count()}});
    FollowPlate();
    return true;
  }

  /// Each frame of the film has its plate, as far as there are plates.
  void FollowPlate() {
    const int wanted = session_->at() * flags_.session_options.step;
    plate_ = std::min(wanted, plates_.count() - 1);
    wants_picture_ = true;
    if (page_) Say(json{{"event", "plate"}, {"plate", plate_}});
  }

  void AddGhost(const PointsX3& points) {
    ghosts_.push_back(points);
    if (static_cast<int>(ghosts_.size()) > flags_.onion) ghosts_.erase(ghosts_.begin());
  }

  /// The poses of the frames before the one that is next.
  void TakeUpGhosts() {
    ghosts_.clear();
    if (!pictures_) return;
    PosedPuppet earlier(parts_);
    for (int f = std::max(0, session_->at() - flags_.onion); f < session_->at(); ++f) {
      earlier.Update(session_->frames()[static_cast<std::size_t>(f)]);
      AddGhost(earlier.points());
    }
  }

  static json Shares(const Latency& latency) {
    return {{"p50", 1e3 * latency.At(0.5)},
            {"p99", 1e3 * latency.At(0.99)},
            {"most", 1e3 * latency.At(1)}};
  }

  void TellStatistics() {
    const double seconds = LiveSeconds(begin_, LiveClock::now());
    Say(json{{"event", "ended"},
             {"seconds", seconds},
             {"updates", number_},
             {"missed", missed_},
             {"updates_a_second", static_cast<double>(number_) / std::max(seconds, 1e-9)},
             {"vertices", parts_.mesh.vertex_count()},
             {"processor_ms_an_update", 1e3 * (ProcessorSeconds() - processor_begin_) /
                                            std::max(1.0, static_cast<double>(number_))},
             {"milliseconds",
              {{"read", Shares(read_)},
               {"match", Shares(match_)},
               {"skin", Shares(skin_)},
               {"values_to_mesh", Shares(pose_)},
               {"request_to_mesh", Shares(whole_)}}},
             {"pictures", pictures_ ? pictures_->written() : 0}});
  }

  const LiveFlags& flags_;
  const PuppetParts parts_;
  Puppet& reader_;
  PosedPuppet posed_;
  PlateFiles plates_;
  Image8 texture_;
  Mesh set_;
  const PuppetLook look_{parts_.mesh, texture_, set_};
  std::unique_ptr<PictureWriter> pictures_;
  std::unique_ptr<RecordingSession> session_;
  std::unique_ptr<PageStream> page_;
  std::vector<PointsX3> ghosts_;
  const bool walks_;
  int plate_ = 0, posed_for_ = -1;
  std::vector<std::int32_t> raw_;
  std::vector<int> wraps_;
  std::set<int> told_still_;
  bool page_moved_ = false, told_waiting_ = false;
  long number_ = 0, missed_ = 0;
  bool wants_picture_ = false, wants_frame_ = false;
  LiveClock::time_point begin_, picture_at_{}, page_at_{};
  double processor_begin_ = 0;
  Latency read_, match_, skin_, pose_, whole_;
};

void RunLive(const LiveFlags& flags, LiveSession& live) {
  LineInput input(STDIN_FILENO);
  const auto period = std::chrono::duration_cast<LiveClock::duration>(
      std::chrono::duration<double>(1 / flags.rate));
  const auto begin = LiveClock::now();
  auto due = begin;
  bool goes_on = true;
  while (goes_on && !WasInterrupted()) {
    live.Step();
    while (goes_on && !input.over()) {
      const std::optional<std::string> line = input.Next(0);
      if (!line) break;
      goes_on = live.Do(*line);
    }
    // Whoever shows the page is gone.
    if (input.over() && !flags.page.empty()) break;
    if (flags.seconds > 0 && LiveSeconds(begin, LiveClock::now()) >= flags.seconds) break;
    due += period;
    for (; due + period < LiveClock::now(); due += period) live.TellMissed();
    std::this_thread::sleep_until(due);
  }
}

int Live(const LiveFlags& flags) {
  LoadedPuppet loaded = LoadPuppet(flags.paths, flags.choices);
  for (const std::string& note : loaded.notes) fmt::print(stderr, "armature live: {}\n", note);
  for (const std::string& warning : loaded.warnings)
    fmt::print(stderr, "armature live: warning: {}\n", warning);
  // One core is left to the stream: pictures are drawn by their own thread alone.
  SetThreadCount(1);
  Puppet reader(flags.puppet);
  const std::string misplaced = loaded.misplaced;
  LiveSession live(flags, std::move(loaded), reader);
  if (!flags.page.empty() && !misplaced.empty())
    fmt::print("{}\n", json{{"event", "warning"}, {"words", misplaced}}.dump());
  RunLive(flags, live);
  reader.SaveCalibration();
  live.Finish();
  return static_cast<int>(WasInterrupted() ? ExitCode::kInterrupted : ExitCode::kOk);
}

void AddCharacter(CLI::App& app, LiveFlags& flags) {
  app.add_option("--chains", flags.paths.chains, "the file of anchors and chains")->required();
  app.add_option("--skeleton", flags.paths.skeleton,
                 "the computer skeleton (.bvh); default: like the armature itself");
  app.add_option("--mesh", flags.paths.mesh, "the character at rest; default: ball and stick");
  app.add_option("--weights", flags.paths.weights,
                 "the mesh's weights (.json, .mhw or .dmat); default: computed by heat");
  app.add_option("--texture", flags.texture, "the mesh's texture");
  app.add_option("--method", flags.choices.method, "both_ends, or greedy as in the paper")
      ->check(CLI::IsMember({"both_ends", "greedy"}))
      ->capture_default_str();
  app.add_option("--unreachable", flags.choices.unreachable,
                 "which anchor a chain keeps that is too short for both")
      ->check(CLI::IsMember({"near", "far", "split"}))
      ->capture_default_str();
  app.add_option("--calm", flags.choices.calm, "how much a match resists changes; 0: not at all")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--armature_up", flags.choices.armature_up, "y or z, in the description")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  app.add_option("--skeleton_up", flags.choices.skeleton_up, "y or z, in the skeleton's file")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
}

void AddPage(CLI::App& app, LiveFlags& flags) {
  app.add_option("--page", flags.page,
                 "folder for what a page needs to show the puppet by itself; each line then has "
                 "bones and sensors, and the program ends with its input");
  app.add_option("--page_rate", flags.page_rate, "lines a second for the page, at most")
      ->check(CLI::Range(0.1, 200.0))
      ->capture_default_str();
  app.add_option("--simulated", flags.simulated,
                 "what a simulated puppet does: it walks, or it takes a pose for each frame of "
                 "the session and rests")
      ->check(CLI::IsMember({"walk", "frames"}))
      ->capture_default_str();
}

void AddStream(CLI::App& app, LiveFlags& flags) {
  app.add_option("--rate", flags.rate, "updates a second")
      ->check(CLI::Range(0.1, 2000.0))
      ->capture_default_str();
  app.add_option("--seconds", flags.seconds, "end after this time; 0: when told to")
      ->check(CLI::Range(0.0, 1e6));
  app.add_flag("--quiet", flags.quiet, "no line for each pose, only for events");
  app.add_option("--pictures", flags.pictures, "folder for numbered pictures");
  app.add_option("--picture_rate", flags.picture_rate, "pictures a second, at most")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  app.add_option("--plate", flags.plate,
                 "background plate of the pictures: a picture, or a folder");
  app.add_option("--shot", flags.shot, "the plates' camera: shot.json, as `locate` writes it");
  app.add_option("--set", flags.set, "geometry of the scene, such as a table, in the shot's world");
  app.add_option("--onion", flags.onion, "recorded frames that stay visible behind the puppet")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  app.add_option("--session", flags.session, "folder of a recording; made, or taken up");
  app.add_option("--fps", flags.session_options.fps, "frames a second of the film")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--step", flags.session_options.step,
                 "frames of the film for each recorded one: 1 on ones, 2 on twos")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
}

}  // namespace

int LiveCommand(int argc, char** argv) {
  CLI::App app(
      "Poses the character by the armature while it is moved, and tells each pose as a line of "
      "JSON.",
      "keypose armature live");
  LiveFlags flags;
  AddPuppetFlags(app, flags.puppet);
  AddCharacter(app, flags);
  AddStream(app, flags);
  AddPage(app, flags);
  app.footer(
      "While it runs, type and press Enter: plate N | plate next | end; with --session also "
      "(only Enter) or record | next | back | goto N | cut | zero JOINT");
  return RunCommandLine(app, argc, argv, [&] {
    flags.paths.description = flags.puppet.description;
    if (flags.simulated == "frames" && flags.session.empty())
      throw UsageError("--simulated frames needs --session: its frames are those of a recording");
    return Live(flags);
  });
}

}  // namespace keypose::armature
