// What the person has asked a session for, heard while it waits for devices.
#pragma once

#include <deque>
#include <functional>
#include <string>

#include "capture/shoot/devices/patience.h"
#include "capture/shoot/session/announcer.h"
#include "capture/shoot/session/conversation.h"
#include "capture/shoot/session/shot_book.h"

namespace keypose::capture::shoot {

/// Thrown out of a wait: the person wants something else now.
struct Rethink {};
/// Thrown out of a wait: the person ends the session.
struct EndAsked {};

class UserRequests final : public Patience {
 public:
  /// Both must outlive this.
  UserRequests(Conversation& talk, Announcer& announcer) : talk_(talk), announcer_(announcer) {}

  /// The pose at work; before the first wait.
  void SetBook(ShotBook* book) { book_ = book; }

  /// @throws Rethink, EndAsked, Cancelled  unless held
  void Wait(double seconds) override;
  double Now() const override { return clock_.Now(); }

  /// While one lives, a wait is not given up: what was begun is brought to its end.
  class Hold {
   public:
    explicit Hold(UserRequests& requests, bool really = true) : requests_(requests), by_(really) {
      requests_.holds_ += by_;
    }
    ~Hold() { requests_.holds_ -= by_; }
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;

   private:
    UserRequests& requests_;
    int by_;
  };

  /// @return why not; "" if it will be shot
  std::string WantAgain(const Command& command);

  bool over() const { return talk_.Over(); }

  Shot target;            ///< at work, set by the session
  bool checking = false;  ///< the target is shot to check its ring, set by the session
  bool paused = false;
  bool done = false;  ///< what was asked for is done
  bool live = false;
  bool skip_check = false;  ///< the ring's check is left out
  std::deque<Shot> again;
  std::string next_pose;           ///< "" for none
  std::optional<int> next_angles;  ///< of it; none: the same plan
  std::optional<double> table_is_at_deg;

 private:
  void Handle(const Command& command);
  std::string Skip(const Command& command);
  std::string NextPose(const Command& command);
  std::string TableIsAt(const Command& command);

  Conversation& talk_;
  Announcer& announcer_;
  ShotBook* book_ = nullptr;
  PlainPatience clock_;
  int holds_ = 0;
  bool ending_ = false, rethink_ = false;
};

}  // namespace keypose::capture::shoot
