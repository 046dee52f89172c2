#include "capture/shoot/talk/terminal_conversation.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cctype>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/shoot/record/shot_plan.h"
#include "core/io/text/files.h"
#include "core/io/text/line_input.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

using nlohmann::json;

std::string Text(const json& event, const char* key) { return event.value(key, ""); }

/// Two sentences that belong together.
std::string Advice(const json& event) {
  const std::string what_to_do = Text(event, "do");
  return Text(event, "words") + (what_to_do.empty() ? "" : "; " + what_to_do);
}

std::string FindingLines(const json& findings) {
  std::string lines;
  for (const json& finding : findings) lines += "      ! " + Advice(finding) + "\n";
  return lines;
}

std::string SessionWords(const json& event) {
  std::string rings;
  for (const double ring : event.at("plan").at("rings_deg"))
    rings += (rings.empty() ? "" : ", ") + DegreesText(ring);
  std::string words =
      fmt::format("pose {}: {} photographs, {} angles of each ring ({} degrees high), into {}\n",
                  Text(event, "pose"), event.at("total").get<int>(),
                  event.at("plan").at("angles").get<int>(), rings, Text(event, "folder"));
  if (const std::string bent = Text(event, "bent_from"); !bent.empty())
    words += fmt::format("'{}' will be bent into them (`method: fit` in pipeline.yaml)\n", bent);
  if (const int done = event.at("done"); done > 0)
    words += fmt::format("{} are there already; it goes on where it was\n", done);
  return words;
}

std::string PhotographWords(const json& event) {
  const json& entry = event.at("entry");
  return fmt::format("  {:3} of {}  {}  sharpness {:.2f}, exposure {:.0f}\n",
                     event.at("done").get<int>(), event.at("total").get<int>(),
                     Text(event, "photograph"), entry.value("crispness", 0.0),
                     entry.value("exposure", 0.0)) +
         FindingLines(entry.at("findings"));
}

std::string RingWords(const json& event) {
  std::string words = fmt::format("ring {} is complete", event.at("ring").get<int>());
  if (event.contains("moved_px"))
    words += fmt::format("; first and last photograph differ by {:.1f} pixels",
                         event.at("moved_px").get<double>());
  return words + "\n" + FindingLines(event.at("findings"));
}

std::string AskWords(const json& event) {
  const std::string more = Text(event, "do");
  return "-> " + Text(event, "words") + ", then press Enter\n" +
         (more.empty() ? "" : "   (" + more + ")\n");
}

std::string DoneWords(const json& event) {
  std::string words = fmt::format("pose {} is done: {} photographs", Text(event, "pose"),
                                  event.at("photographs").get<int>());
  if (const int count = event.at("with_findings"); count > 0)
    words += fmt::format(", {} with findings (see shoot.json)", count);
  return words + "\ntype `next NAME` for the next pose, `again ANGLE`, or `end`\n";
}

std::string ChangedWords(const json& event) {
  std::string words;
  for (const auto& [name, findings] : event.at("photographs").items())
    words += findings.empty() ? fmt::format("      {}: nothing is wrong any more\n", name)
                              : fmt::format("      {}:\n", name) + FindingLines(findings);
  return words;
}

class Terminal final : public Conversation {
 public:
  Terminal(int in, int out) : input_(in), out_(out) {}

  void Tell(const json& event) override {
    std::string words = SentenceOf(event);
    if (Text(event, "event") == "session") by_folder_ = Text(event, "camera") == "folder";
    if (by_folder_ && Text(event, "state") == "shooting")
      words = fmt::format("  waiting for the photograph at {} degrees\n",
                          DegreesText(event.at("angle_deg")));
    while (!words.empty()) {
      const ssize_t written = ::write(out_, words.data(), words.size());
      if (written <= 0) return;  // the reader has closed the pipe, as `head` does
      words.erase(0, static_cast<std::size_t>(written));
    }
  }

  std::optional<Command> Hear(double timeout_s) override {
    const auto line = input_.Next(timeout_s);
    if (!line) return std::nullopt;
    try {
      return ParseWords(*line);
    } catch (const InputError& error) {
      Tell({{"event", "refused"}, {"words", error.what()}});
      return std::nullopt;
    }
  }

  bool Over() const override { return input_.over(); }
  bool Interrupted() const override { return WasInterrupted(); }

 private:
  LineInput input_;
  int out_;
  bool by_folder_ = false;
};

[[noreturn]] void RefuseWord(const std::string& word) {
  const std::string near = NearestWord(word, {"again", "skip", "pause", "go", "at", "next", "end"});
  throw InputError("'" + WithoutOddBytes(word) + "' is not known; did you mean `" + near +
                   "`? Only Enter goes on");
}

int AnglesOf(const std::string& word) {
  char* end = nullptr;
  const long angles = std::strtol(word.c_str(), &end, 10);
  if (*end || angles < 1 || angles > 360)
    throw InputError("'" + WithoutOddBytes(word) + "' is no number of angles, as in `next bent 6`");
  return static_cast<int>(angles);
}

}  // namespace

Command ParseWords(const std::string& line) {
  std::istringstream in(line);
  std::string word, rest;
  in >> word;
  std::getline(in >> std::ws, rest);
  while (!rest.empty() && std::isspace(static_cast<unsigned char>(rest.back()))) rest.pop_back();
  Command command;
  command.word = word;
  using Kind = Command::Kind;
  const auto needs = [&](const char* what) {
    if (rest.empty()) throw InputError("`" + word + "` needs " + what);
  };
  if (word.empty() || word == "go" || word == "shoot" || word == "done") {
    command.kind = Kind::kGoOn;
  } else if (word == "again") {
    needs("an angle or a photograph, as in `again 45`");
    command.kind = Kind::kAgain;
    command.photograph = rest;
  } else if (word == "skip") {
    command.kind = Kind::kSkip;
    command.photograph = rest;
  } else if (word == "pause") {
    command.kind = Kind::kPause;
  } else if (word == "at") {
    needs("an angle, as in `at 45`");
    char* end = nullptr;
    command.kind = Kind::kAt;
    command.angle_deg = std::strtod(rest.c_str(), &end);
    if (*end) throw InputError("'" + rest + "' is no angle");
  } else if (word == "next") {
    needs("the pose's name, as in `next bent`");
    command.kind = Kind::kNextPose;
    std::istringstream words(rest);
    std::string angles;
    words >> command.pose >> angles;
    if (!angles.empty()) command.angles = AnglesOf(angles);
  } else if (word == "end" || word == "quit" || word == "exit") {
    command.kind = Kind::kEnd;
  } else {
    RefuseWord(word);
  }
  return command;
}

std::string SentenceOf(const json& event) {
  const std::string kind = Text(event, "event");
  if (kind == "session") return SessionWords(event);
  if (kind == "photograph") return PhotographWords(event);
  if (kind == "findings") return ChangedWords(event);
  if (kind == "ring") return RingWords(event);
  if (kind == "ask") return AskWords(event);
  // What needs a hand is asked for right after it.
  if (kind == "fault")
    return "! " + (event.at("needs_hand") ? Text(event, "words") : Advice(event)) + "\n";
  if (kind == "pose-done") return DoneWords(event);
  if (kind == "recovered" || kind == "refused") return Text(event, "words") + "\n";
  if (kind == "ended") return Text(event, "words") + "\n";
  return "";
}

std::unique_ptr<Conversation> MakeTerminal(int in, int out) {
  return std::make_unique<Terminal>(in, out);
}

}  // namespace keypose::capture::shoot
