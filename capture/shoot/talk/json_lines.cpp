#include "capture/shoot/talk/json_lines.h"

#include <unistd.h>

#include <cerrno>
#include <map>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/io/text/line_input.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

using nlohmann::json;

const std::map<std::string, Command::Kind> kWords = {
    {"shoot", Command::Kind::kGoOn}, {"done", Command::Kind::kGoOn},
    {"go-on", Command::Kind::kGoOn}, {"again", Command::Kind::kAgain},
    {"skip", Command::Kind::kSkip},  {"pause", Command::Kind::kPause},
    {"at", Command::Kind::kAt},      {"next-pose", Command::Kind::kNextPose},
    {"live", Command::Kind::kLive},  {"end", Command::Kind::kEnd}};

class JsonLines final : public Conversation {
 public:
  JsonLines(int in, int out) : input_(in), out_(out) {}

  void Tell(const json& event) override {
    std::string line = event.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
    while (!line.empty() && !deaf_) {
      const ssize_t written = ::write(out_, line.data(), line.size());
      if (written > 0)
        line.erase(0, static_cast<std::size_t>(written));
      else if (errno != EINTR)
        deaf_ = true;  // nobody listens any more
    }
  }

  std::optional<Command> Hear(double timeout_s) override {
    if (Over() && !std::exchange(told_end_, true)) {
      Command end;
      end.kind = Command::Kind::kEnd;
      end.word = "end";
      return end;
    }
    const auto line = input_.Next(timeout_s);
    if (!line || line->empty()) return std::nullopt;
    try {
      return ParseJsonCommand(*line);
    } catch (const InputError& error) {
      Tell({{"event", "refused"}, {"command", ""}, {"words", error.what()}});
      return std::nullopt;
    }
  }

  bool Over() const override { return deaf_ || input_.over(); }
  bool Interrupted() const override { return WasInterrupted(); }

 private:
  LineInput input_;
  int out_;
  bool deaf_ = false, told_end_ = false;
};

}  // namespace

Command ParseJsonCommand(const std::string& line) {
  try {
    if (!IsShallowJson(line)) throw InputError("the command is nested too deep");
    const json root = json::parse(line);
    Command command;
    command.word = root.at("command").get<std::string>();
    const auto word = kWords.find(command.word);
    if (word == kWords.end()) throw InputError("the command '" + command.word + "' is not known");
    command.kind = word->second;
    command.photograph = root.value("photograph", "");
    if (root.contains("angle_deg")) command.angle_deg = root.at("angle_deg").get<double>();
    if (root.contains("ring")) command.ring = root.at("ring").get<int>();
    if (root.contains("flip")) command.flip = root.at("flip").get<int>();
    command.pose = root.value("pose", "");
    if (root.contains("angles")) command.angles = root.at("angles").get<int>();
    command.on = root.value("on", false);
    if (root.contains("id")) command.id = root.at("id").dump();
    return command;
  } catch (const json::exception& error) {
    throw InputError("this is no command: " + JsonFault(error));
  }
}

std::unique_ptr<Conversation> MakeJsonLines(int in, int out) {
  return std::make_unique<JsonLines>(in, out);
}

}  // namespace keypose::capture::shoot
