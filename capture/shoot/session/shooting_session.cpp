#include "capture/shoot/session/shooting_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "capture/shoot/develop/focus_stack.h"
#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/session/announcer.h"
#include "capture/shoot/session/helper.h"
#include "capture/shoot/session/project.h"
#include "capture/shoot/session/shot_book.h"
#include "capture/shoot/session/shot_checks.h"
#include "capture/shoot/session/user_requests.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/io/text/pose_yaml.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

/// Why the files of an exposure cannot be used; "" if they can.
std::string FaultOf(const Exposure& exposure) {
  try {
    for (const fs::path& file : exposure.files) ReadPhotograph(file);
    return exposure.files.empty() ? "the camera gave no file" : "";
  } catch (const InputError&) {
    return "the photograph came only in part, or damaged";
  }
}

/// The developed picture of an exposure: its JPEG if there is one, else its RAW file.
fs::path PictureOf(const Exposure& exposure) {
  return *std::max_element(
      exposure.files.begin(), exposure.files.end(),
      [](const fs::path& a, const fs::path& b) { return IsRawName(a) > IsRawName(b); });
}

std::optional<SideFile> SideFileOf(const fs::path& folder) {
  try {
    return fs::exists(folder / kShootNotes)
               ? std::optional(ParseSideFile(ReadFile(folder / kShootNotes), "shoot.json"))
               : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;  // the book tells of it
  }
}

/// The side file of the pose that was shot last, besides `pose`.
std::optional<SideFile> NewestOther(const fs::path& photos, const std::string& pose) {
  fs::path newest;
  fs::file_time_type newest_time;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(photos, ignored)) {
    std::error_code missing;
    const fs::path file = entry.path() / "shoot.json";
    const auto time = fs::last_write_time(file, missing);
    if (missing || entry.path().filename() == pose) continue;
    if (newest.empty() || time > newest_time) {
      newest = file;
      newest_time = time;
    }
  }
  if (newest.empty()) return std::nullopt;
  try {
    SideFile side = ParseSideFile(ReadFile(newest), newest.string());
    side.pose = newest.parent_path().filename();  // the folder may have been renamed since
    return side;
  } catch (const InputError&) {
    return std::nullopt;  // another pose's damage is told when that pose is shot
  }
}

class ShootingSession {
 public:
  ShootingSession(const ShootingOptions& options, const ShootingParts& parts)
      : options_(options),
        parts_(parts),
        lock_(StateFolder()),
        announcer_(parts.talk, options.project),
        requests_(parts.talk, announcer_),
        helper_(options_, parts_, announcer_, requests_, StateFolder() / "stand.json") {
    requests_.paused = !options.begins_at_once;
    requests_.live = options.live;
  }

  bool Run() {
    OpenPose(options_.pose, options_.plan, options_.plan_given);
    WantAgain();
    try {
      Connect();
      while (true) {
        try {
          Step();
        } catch (const Rethink&) {
        }
      }
    } catch (const EndAsked&) {
    }
    book_->Save();
    announcer_.State("ended", *book_, requests_.target);
    announcer_.Ended(*book_);
    return book_->Complete();
  }

 private:
  fs::path StateFolder() const { return options_.project / ".keypose" / "shoot"; }

  // ---- what to do next

  void Connect() {
    while (true) {
      try {
        helper_.ConnectAll();
        break;
      } catch (const Rethink&) {
      }
    }
    if (book_->side().camera == parts_.camera.Name()) return;
    book_->side().camera = parts_.camera.Name();
    book_->Save();
    announcer_.PoseOpened(*book_, onion_, bent_from_);
  }

  void WantAgain() {
    if (options_.again.empty()) return;
    Command again;
    again.photograph = options_.again;
    requests_.target = book_->Next().shot;
    if (const std::string refusal = requests_.WantAgain(again); !refusal.empty())
      throw UsageError("--again " + options_.again + ": " + refusal);
  }

  void Step() {
    requests_.Wait(0);
    if (!requests_.next_pose.empty()) return BeginNextPose();
    if (requests_.table_is_at_deg)
      return helper_.TableIsAt(*std::exchange(requests_.table_is_at_deg, std::nullopt));
    if (requests_.paused) return Idle("paused");
    if (!requests_.again.empty()) {
      const Shot shot = requests_.again.front();
      Shoot(shot);
      const auto done = std::find(requests_.again.begin(), requests_.again.end(), shot);
      if (done != requests_.again.end()) requests_.again.erase(done);
      return;
    }
    const NextThing next = book_->Next();
    if (next.kind == NextThing::Kind::kShoot) return Shoot(next.shot);
    if (next.kind == NextThing::Kind::kCheckRing) return CheckRing(next.shot);
    if (!std::exchange(told_done_, true)) announcer_.PoseDone(*book_);
    if (!options_.stays_when_complete) throw EndAsked{};
    Idle("idle");
  }

  void Idle(const char* state) {
    announcer_.State(state, *book_, requests_.target);
    if (requests_.over()) throw EndAsked{};
    helper_.LiveFrame();
    requests_.Wait(0.1);
  }

  // ---- poses

  /// A pose after the first that gets few angles, and of which no rings were said, has one ring, as
  /// high as the first one of the pose that was shot last.
  ShotPlan PlanOf(const std::string& pose, ShotPlan plan, bool given,
                  const std::optional<SideFile>& other) const {
    const bool few = plan.angles < kFewestOfAScan && HasOtherPose(options_.project, pose);
    if (!given || options_.rings_given || !few) return plan;
    const std::optional<SideFile> own = SideFileOf(options_.project / "photos" / pose);
    if (own) plan.rings_deg = own->plan.rings_deg;
    if (!own && other) plan.rings_deg = other->plan.rings_deg;
    if (!own) plan.rings_deg.resize(1);
    return plan;
  }

  void OpenPose(const std::string& pose, const ShotPlan& wish, bool plan_given) {
    const std::optional<SideFile> other = NewestOther(options_.project / "photos", pose);
    const ShotPlan plan = PlanOf(pose, wish, plan_given, other);
    const PosePlace place = AddPose(options_.project, pose, SizeOf(AllShots(plan)));
    book_.reset();  // its folder is tidied up first
    book_ = std::make_unique<ShotBook>(place.folder, pose, plan, plan_given);
    requests_.SetBook(book_.get());
    helper_.SetBook(book_.get());
    requests_.again.clear();
    told_done_ = false;
    onion_ = other ? options_.project / "photos" / other->pose : fs::path();
    SideFile& side = book_->side();
    side.camera = parts_.camera.Name();
    side.turntable = options_.turntable_name;
    if (options_.white || options_.forget_white)
      side.white = options_.white;
    else if (!side.white && other)
      side.white = other->white;
    book_->Save();
    if (parts_.pose_begins) parts_.pose_begins(pose, side.plan);
    requests_.target = book_->Next().shot;
    bent_from_ = place.bent_from;
    announcer_.PoseOpened(*book_, onion_, bent_from_);
  }

  void BeginNextPose() {
    const std::string pose = std::exchange(requests_.next_pose, "");
    ShotPlan plan = book_->side().plan;
    if (const auto angles = std::exchange(requests_.next_angles, std::nullopt)) {
      plan.rings_deg.resize(1);
      plan.angles = *angles;
      plan.flips = 0;
    }
    OpenPose(pose, plan, false);
    requests_.paused = false;
  }

  // ---- one photograph

  void Shoot(const Shot& shot) {
    told_done_ = false;
    requests_.target = shot;
    while (true) {
      try {
        SetUp(shot);
        Turn(shot);
        const std::vector<Exposure> exposures = TakeAll();
        const UserRequests::Hold hold(requests_);  // what was exposed lands before anything else
        const bool again = book_->Has(shot);
        Add(shot, exposures);
        const std::vector<Shot> changed = book_->Enter(shot);
        book_->Save();
        announcer_.Landed(*book_, shot, again, changed);
        return;
      } catch (const DiskError& error) {
        announcer_.Fault({"disk-full", error.what(), "free some space", true});
        helper_.Ask("disk", "free some space on the project's disk", "");
      }
    }
  }

  static const char* HowToLay(int flip) {
    if (flip == 0) return "stand the figure upright";
    if (flip == 1) return "lay the figure on its side, in the middle of the table";
    return "turn the figure onto a side that was not below yet";
  }

  /// Camera height and figure as this photograph needs them.
  void SetUp(const Shot& shot) {
    SetupState& setup_state = helper_.setup_state;
    const bool other_pose = setup_state.pose != book_->side().pose;
    if (setup_state.flip != shot.flip || (other_pose && shot.flip > 0))
      helper_.Ask("flip", HowToLay(shot.flip), "leave the camera where it is");
    if (setup_state.ring != shot.ring || other_pose) AskForHeight(shot, other_pose);
    if (setup_state.flip == shot.flip && setup_state.ring == shot.ring && !other_pose) return;
    setup_state.flip = shot.flip;
    setup_state.ring = shot.ring;
    setup_state.pose = book_->side().pose;
    helper_.SaveSetupState();
  }

  void AskForHeight(const Shot& shot, bool other_pose) {
    const ShotPlan& plan = book_->side().plan;
    const std::string first =
        other_pose ? fmt::format("put the figure in its pose '{}' in the middle of the table, and ",
                                 book_->side().pose)
                   : "";
    const std::string mark = parts_.turntable || !other_pose
                                 ? ""
                                 : fmt::format("; the table's mark at {} degrees",
                                               DegreesText(helper_.setup_state.table_deg));
    helper_.Ask("camera-height",
                fmt::format("{}set the camera to {} degrees above the table{}", first,
                            DegreesText(TiltOf(plan, shot)), mark),
                "aim it at the figure's middle; the whole figure must stay in the picture while it "
                "turns; leave zoom and exposure as they are");
  }

  void Turn(const Shot& shot) {
    SetupState& setup_state = helper_.setup_state;
    const double angle_deg = AngleOf(book_->side().plan, shot);
    if (!parts_.turntable) {
      if (setup_state.table_deg != angle_deg)
        helper_.Ask("turn", fmt::format("turn the table to {} degrees", DegreesText(angle_deg)),
                    parts_.camera.OnlyArrives() ? "then release the camera" : "", angle_deg);
    } else {
      announcer_.State("turning", *book_, shot);
      setup_state.turning_to = angle_deg;
      setup_state.memory = parts_.turntable->Memory();
      helper_.SaveSetupState();
      helper_.WithTable([&] {
        const UserRequests::Hold hold(requests_);
        parts_.turntable->TurnTo(angle_deg, requests_);
      });
    }
    setup_state.table_deg = angle_deg;
    setup_state.turning_to.reset();
    helper_.SaveSetupState();
    if (!parts_.turntable) return;
    announcer_.State("settling", *book_, shot);
    requests_.Wait(options_.settle_s);
  }

  std::vector<Exposure> TakeAll() {
    const int count = book_->side().plan.focus_stack;
    const auto own = helper_.TakeOwnRelease();  // lies in the incoming folder
    if (own && FaultOf(*own).empty() && count == 1) return {*own};
    const fs::path incoming = book_->store().Incoming();
    std::vector<Exposure> exposures;
    for (int i = 0; i < count; ++i) {
      if (count > 1 && !parts_.camera.Focus(i, count, requests_))
        helper_.Ask(
            "camera",
            fmt::format("set the focus for photograph {} of {}, from near to far", i + 1, count),
            "");
      exposures.push_back(TakeWhole(incoming / fmt::format("f{}", i + 1)));
    }
    return exposures;
  }

  /// Releases the camera until a photograph is whole on the disk.
  Exposure TakeWhole(const fs::path& into) {
    constexpr int kByItself = 3;
    for (int attempt = 0;; ++attempt) {
      announcer_.State("shooting", *book_, requests_.target);
      const Exposure exposure = Take(into, attempt > 0);
      announcer_.State("checking", *book_, requests_.target);
      const std::string fault = FaultOf(exposure);
      if (fault.empty()) return exposure;
      const bool by_hand = attempt + 1 >= kByItself;
      announcer_.Fault({"cut-short", fault,
                        by_hand ? "see whether the cable is firm and the card is sound"
                                : "it is fetched or shot again by itself",
                        by_hand});
      if (by_hand) helper_.Ask("camera", "see whether the camera's cable and card are sound", "");
    }
  }

  Exposure Take(const fs::path& into, bool fetch_again) {
    Exposure exposure;
    helper_.WithCamera([&] {
      fs::remove_all(into);
      fs::create_directories(into);
      // Somebody else's release is waited for, and that wait may be given up. Our own is fetched.
      const UserRequests::Hold hold(requests_, !parts_.camera.OnlyArrives());
      exposure = parts_.camera.Take(into, fetch_again, requests_);
    });
    return exposure;
  }

  void Add(const Shot& shot, const std::vector<Exposure>& exposures) {
    const std::string name = book_->Name(shot);
    const std::int64_t time = exposures.front().time.value_or(parts_.clock.Now());
    if (shot.index == 0) book_->ForgetRing(shot);
    if (exposures.size() == 1) return book_->store().Add(name, exposures.front(), time);
    std::vector<Image8> images;
    for (const Exposure& exposure : exposures)
      images.push_back(ReadPhotograph(PictureOf(exposure)));
    const ImageInfo info = ReadPhotographInfo(PictureOf(exposures.front()));
    ExifToWrite exif;
    exif.focal_mm = info.focal_mm.value_or(0);
    exif.focal_35mm = info.focal_35mm.value_or(0);
    exif.model = info.camera_model;
    const fs::path merged = book_->folder() / ".incoming" / "merged.jpg";
    WriteImage(merged, MergeFocusStack(images), 97, &exif);
    book_->store().AddStack(name, exposures, merged, time);
  }

  // ---- a ring's end

  /// Photographs the first angle once more, to see whether the figure has moved meanwhile.
  void CheckRing(const Shot& first) {
    std::optional<double> moved_px;
    const bool possible = book_->Has(first) && book_->side().photographs.at(first).readable;
    if (possible && !requests_.skip_check) {
      requests_.target = first;
      requests_.checking = true;
      try {
        moved_px = MovedSince(first);
      } catch (const Rethink&) {
        requests_.checking = false;
        if (!requests_.skip_check) throw;
      } catch (...) {
        requests_.checking = false;
        throw;
      }
      requests_.checking = false;
    }
    requests_.skip_check = false;
    book_->CheckRing(first, moved_px);
    book_->Save();
    announcer_.RingChecked(*book_, first);
  }

  double MovedSince(const Shot& first) {
    SetUp(first);
    Turn(first);
    const auto own = helper_.TakeOwnRelease();
    const Exposure last =
        own && FaultOf(*own).empty() ? *own : TakeWhole(book_->store().Incoming() / "f1");
    const fs::path file = book_->folder() / book_->side().photographs.at(first).file;
    const Image8 before = ReadPhotograph(file), after = ReadPhotograph(PictureOf(last));
    if (before.width == after.width && before.height == after.height)
      return MovedBetween(before, after);
    throw InputError(
        "the camera's picture size has changed while the ring was shot; set it as "
        "before, and start again");
  }

  ShootingOptions options_;
  ShootingParts parts_;
  ShootLock lock_;
  Announcer announcer_;
  UserRequests requests_;
  Helper helper_;
  std::unique_ptr<ShotBook> book_;
  fs::path onion_;  // the folder of the pose that was shot before
  std::string bent_from_;
  bool told_done_ = false;
};

}  // namespace

bool RunShootingSession(const ShootingOptions& options, const ShootingParts& parts) {
  return ShootingSession(options, parts).Run();
}

}  // namespace keypose::capture::shoot
