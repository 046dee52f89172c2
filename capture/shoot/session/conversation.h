// The other end of a session: a person at a terminal, or a program.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace keypose::capture::shoot {

/// What the person wants.
struct Command {
  enum class Kind { kGoOn, kAgain, kSkip, kPause, kAt, kNextPose, kLive, kEnd };
  Kind kind = Kind::kGoOn;
  std::string photograph;           ///< kAgain, kSkip: its name
  std::optional<double> angle_deg;  ///< kAgain, kAt
  std::optional<int> ring, flip;    ///< kAgain, with an angle
  std::string pose;                 ///< kNextPose
  std::optional<int> angles;        ///< kNextPose: so many, of the first ring alone
  bool on = false;                  ///< kLive
  std::string id;                   ///< JSON to be given back; "" for none
  std::string word;                 ///< as it was given, for the answer
};

class Conversation {
 public:
  virtual ~Conversation() = default;
  /// @param event  as in docs/shoot.md
  virtual void Tell(const nlohmann::json& event) = 0;
  /// The next command; nothing if none came in time. What cannot be understood is answered at once.
  virtual std::optional<Command> Hear(double timeout_s) = 0;
  /// No command will come any more.
  virtual bool Over() const = 0;
  /// Ctrl-C.
  virtual bool Interrupted() const = 0;
};

}  // namespace keypose::capture::shoot
