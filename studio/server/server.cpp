#include "studio/server/server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <netinet/tcp.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <utility>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/http/guard.h"
#include "studio/http/page_files.h"
#include "studio/project/known_projects.h"
#include "studio/routes/routes.h"
#include "studio/runs/children.h"
#include "studio/server/door.h"

// A macro of resolv.h, and a name within Eigen, which later sources of a batch include.
#undef _res

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

constexpr char kMarkHeader[] = "X-Keypose-Project";
constexpr int kUsualPort = 4777, kOtherPorts = 20;
// A client that says nothing, and a tab that listens for events, each hold a thread.
constexpr int kThreads = 256, kWaiting = 256;
constexpr std::size_t kMostBody = 512u << 20;
// Nothing but the studio's own files; no inline script; nobody may frame it.
constexpr char kPagePolicy[] =
    "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' blob: data:; media-src 'self' blob:; connect-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
// The report has its script and pictures in itself. It gets no access to the studio.
constexpr char kReportPolicy[] =
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline' blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; connect-src data: blob:; media-src data: "
    "blob:; "
    "frame-ancestors 'self'";

fs::path SessionFile(const fs::path& folder) { return folder / ".keypose/studio/session"; }

/// Keeps the session's secret, so that a tab goes on after the studio was started again. A folder
/// without a project stays empty.
void KeepSession(const fs::path& folder, const std::string& secret) {
  const fs::path file = SessionFile(folder);
  const bool used = fs::exists(folder / "pipeline.yaml") || fs::exists(folder / "armature");
  if (!used || fs::exists(file)) return;
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  WriteFileAtomically(file, secret);
  chmod(file.c_str(), 0600);
}

std::string DoorSecret() {
  const fs::path state = UserStateFolder(), file = state / "session";
  std::error_code error;
  if (!state.empty() && fs::is_regular_file(file, error)) {
    const std::string secret = ReadFile(file);
    if (secret.size() == 64) return secret;
  }
  const std::string secret = RandomDigits(256);
  if (state.empty()) return secret;
  try {
    fs::create_directories(state);
    WriteFileAtomically(file, secret);
    chmod(file.c_str(), 0600);
  } catch (const std::exception&) {
    // It is the session of this one time then.
  }
  return secret;
}

/// The secret of the last session here, or a new one. Without a project, that of the person's own
/// first page.
std::string SessionSecret(const fs::path& folder) {
  if (folder.empty()) return DoorSecret();
  const fs::path file = SessionFile(folder);
  std::error_code error;
  if (fs::is_regular_file(file, error)) {
    const std::string secret = ReadFile(file);
    if (secret.size() == 64) return secret;
    fs::remove(file, error);
  }
  const std::string secret = RandomDigits(256);
  KeepSession(folder, secret);
  return secret;
}

std::string PathOf(const httplib::Request& request) { return request.path; }

RequestHead HeadOf(const httplib::Request& request) {
  RequestHead head;
  head.method = request.method;
  head.path = PathOf(request);
  head.host = request.get_header_value("Host");
  head.origin = request.get_header_value("Origin");
  head.cookies = request.get_header_value("Cookie");
  head.fetch_site = request.get_header_value("Sec-Fetch-Site");
  head.own_header = request.get_header_value("X-Keypose");
  const std::string length = request.get_header_value("Content-Length");
  if (!length.empty() && length.find_first_not_of("0123456789") == std::string::npos)
    head.body_bytes = length.size() > 18 ? ~std::uint64_t{0} : std::stoull(length);
  return head;
}

void SetCommonHeaders(httplib::Response& response) {
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("Cross-Origin-Resource-Policy", "same-origin");
  response.set_header("Cross-Origin-Opener-Policy", "same-origin");
  response.set_header("Cache-Control", "no-store");
}

void Refuse(const Refusal& refusal, httplib::Response& response) {
  response.status = refusal.status;
  response.set_content("{\"error\": \"" + refusal.words + "\"}", "application/json");
}

Question QuestionOf(const httplib::Request& request) {
  Question question{request.method, PathOf(request), {}, request.body};
  for (const auto& [name, value] : request.params) question.query[name] = value;
  return question;
}

/// A file in pieces, so that a film of a gigabyte is not held in memory.
void SendFile(const Answer& answer, const httplib::Request& request, httplib::Response& response) {
  const std::string tag = TagOf(answer.file);
  response.set_header("ETag", tag);
  response.headers.erase("Cache-Control");
  response.set_header("Cache-Control", "private, no-cache");
  if (!tag.empty() && request.get_header_value("If-None-Match") == tag) {
    response.status = 304;
    return;
  }
  auto in = std::make_shared<std::ifstream>(answer.file, std::ios::binary);
  std::error_code error;
  const auto size = fs::file_size(answer.file, error);
  if (!*in || error) {
    response.status = 404;
    response.set_content("{\"error\": \"the file is gone\"}", "application/json");
    return;
  }
  response.set_content_provider(
      size, answer.type.c_str(),
      [in](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        char buffer[64 << 10];
        in->seekg(static_cast<std::streamoff>(offset));
        in->read(buffer, static_cast<std::streamsize>(std::min(length, sizeof buffer)));
        return in->gcount() > 0 && sink.write(buffer, static_cast<std::size_t>(in->gcount()));
      });
}

/// As it is. The library would compress texts as well as Brotli can, which takes seconds for the
/// page's program, to save what costs nothing on the loopback; what is given in pieces it leaves
/// alone.
/// @param bytes  stay where they are until `owner` is gone
void SendBytes(std::string_view bytes, std::shared_ptr<const void> owner, const std::string& type,
               httplib::Response& response) {
  if (bytes.empty()) return response.set_content("", type.c_str());
  response.set_content_provider(
      bytes.size(), type.c_str(),
      [bytes, owner = std::move(owner)](std::size_t offset, std::size_t length,
                                        httplib::DataSink& sink) {
        return sink.write(bytes.data() + offset, length);
      });
}

/// For a header: every byte that is not a letter or digit of ASCII as %XX.
std::string PercentEncoded(const std::string& text) {
  std::string encoded;
  for (const char c : text) {
    const bool plain =
        std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-';
    encoded += plain && static_cast<signed char>(c) > 0
                   ? std::string(1, c)
                   : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return encoded;
}

void Send(const Question& question, Answer answer, const httplib::Request& request,
          httplib::Response& response) {
  response.status = answer.status;
  if (!answer.download.empty())
    response.set_header("Content-Disposition",
                        "attachment; filename*=UTF-8''" + PercentEncoded(answer.download));
  if (question.path.starts_with("/report/"))
    response.set_header("Content-Security-Policy", kReportPolicy);
  if (!answer.file.empty()) {
    SendFile(answer, request, response);
  } else {
    const auto bytes = std::make_shared<const std::string>(std::move(answer.bytes));
    SendBytes(*bytes, bytes, answer.type, response);
  }
}

/// Ends all connections to this port of this process. The library waits seconds for callers that
/// say nothing.
void ShutDownConnections(int port) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd", error)) {
    const int fd = std::atoi(entry.path().filename().c_str());
    sockaddr_in own = {}, other = {};
    socklen_t size = sizeof own, other_size = sizeof other;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size) != 0) continue;
    if (getpeername(fd, reinterpret_cast<sockaddr*>(&other), &other_size) != 0) continue;
    if (own.sin_family == AF_INET && ntohs(own.sin_port) == port) shutdown(fd, SHUT_RDWR);
  }
}

std::string PageType(const std::string& name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".css")) return "text/css";
  if (name.ends_with(".js")) return "text/javascript";
  if (name.ends_with(".svg")) return "image/svg+xml";
  return "application/octet-stream";
}

bool SendPage(const std::vector<PageFile>& page, const std::string& path,
              httplib::Response& response) {
  const std::string name = path == "/" ? "index.html" : path.substr(1);
  for (const PageFile& file : page) {
    if (file.name != name) continue;
    response.set_header("Content-Security-Policy", kPagePolicy);
    SendBytes({file.bytes.data(), file.bytes.size()}, nullptr, PageType(name), response);
    return true;
  }
  return false;
}

/// What a browser sees that is not let in.
std::string ClosedDoor(const std::string& words) {
  return "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Keypose studio</title>"
         "<style>body{font:16px/1.5 sans-serif;max-width:34em;margin:15vh auto;padding:0 1em;"
         "color-scheme:light dark}a{font-weight:600}</style><h1>This browser is not let in yet</h1>"
         "<p>" +
         words + "</p></html>";
}
constexpr char kHowToEnter[] =
    "Each address of the studio lets one browser in. Where it was started, press Enter, or <a "
    "href=\"/enter?again=1\">print a new address there</a>, and open it here. A browser that is "
    "let "
    "in has it too: <i>Another browser</i>, on its first page. Was the studio started from the "
    "menu of applications? Start it there again: it comes to the one that is open.";
constexpr char kPrinted[] =
    "A new address was printed where the studio was started: open it in this browser.";

bool WantsPage(const httplib::Request& request) {
  return request.method == "GET" &&
         request.get_header_value("Accept").find("text/html") != std::string::npos;
}

/// What `keypose studio` needs to know of one that is at work without a project of its own.
fs::path RunningFile() { return UserStateFolder() / "server.json"; }

}  // namespace

struct StudioServer::Impl {
  explicit Impl(const ServerOptions& options)
      : session(SessionSecret(options.folder)), page(*options.page), door(ForDoor(options)) {
    if (!options.folder.empty()) door.Open(options.folder);
    server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server.set_payload_max_length(kMostBody);
    server.set_keep_alive_max_count(1000);
    server.set_read_timeout(5, 0);
    server.set_write_timeout(10, 0);
    port = Bind(options.port);
  }

  DoorOptions ForDoor(const ServerOptions& options) {
    return {options.home, UserStateFolder(), pipeline::ProgramFolder(),
            [this] { return Address(guard->NewToken()); },
            [this] {
              if (end) end();
            }};
  }

  int Bind(std::optional<int> given) {
    const int wanted = given.value_or(-1);
    const int first = wanted > 0 ? wanted : kUsualPort;
    const int tries = wanted > 0 ? 1 : kOtherPorts;
    server.set_socket_options([this](socket_t socket) {
      const int on = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
      setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      listener = socket;
    });
    if (wanted == 0) {
      const int any = server.bind_to_any_port("127.0.0.1");
      if (any <= 0) throw UsageError("no port is free");
      listen(listener, kWaiting);
      return any;
    }
    for (int i = 0; i < tries; ++i) {
      if (!server.bind_to_port("127.0.0.1", first + i)) continue;
      // The library lets five callers wait; tabs with many pictures are more.
      listen(listener, kWaiting);
      return first + i;
    }
    throw UsageError(fmt::format("port {} is taken; leave --port out, or choose another", first));
  }

  void SetUp() {
    server.set_pre_routing_handler([this](const auto& request, auto& response) {
      SetCommonHeaders(response);
      const auto refusal = guard->Judge(HeadOf(request));
      if (!refusal) return httplib::Server::HandlerResponse::Unhandled;
      Refuse(*refusal, response);
      if (refusal->status == 403 && WantsPage(request)) ShowDoor(kHowToEnter, response);
      // What a refused request still sends is not read.
      response.set_header("Connection", "close");
      return httplib::Server::HandlerResponse::Handled;
    });
    server.set_exception_handler([](const auto&, auto& response, std::exception_ptr) {
      response.status = 500;
      response.set_content("{\"error\": \"a bug in the studio\"}", "application/json");
    });
    server.Get("/enter", [this](const auto& request, auto& response) { Enter(request, response); });
    server.Get("/api/events", [this](const auto&, auto& response) { SendEvents(response); });
    const auto any = [this](const httplib::Request& request, httplib::Response& response) {
      if (request.method == "GET" && SendPage(page, PathOf(request), response)) return;
      const Question question = QuestionOf(request);
      if (question.path == "/api/door" || question.path.starts_with("/api/door/")) {
        Answer answer = door.Handle(question);
        // What is given in pieces is cut off when the server ends.
        if (question.path == "/api/door/end") {
          response.status = answer.status;
          return response.set_content(answer.bytes, answer.type.c_str());
        }
        Send(question, std::move(answer), request, response);
        return;
      }
      Answer answer = AnswerOfProject(question, request.get_header_value(kMarkHeader), response);
      // A project is made by the page, or by `keypose shoot`; every tab then asks for it.
      if (question.path == "/api/project" || question.path == "/api/armature") Keep();
      Send(question, std::move(answer), request, response);
    };
    server.Get(".*", any);
    server.Post(".*", any);
    server.Put(".*", any);
  }

  void Keep() {
    if (const fs::path now = door.Folder(); !now.empty()) KeepSession(now, session);
    door.RememberIt();
  }

  /// @param mark  of the project that the page shows; "": it does not say
  Answer AnswerOfProject(const Question& question, const std::string& mark,
                         httplib::Response& response) {
    const std::shared_ptr<Routes> open = door.Now();
    if (!open) return ErrorAnswer(404, "no project is open; choose one first");
    const std::string now = door.Mark();
    response.set_header(kMarkHeader, now);
    if (question.method != "GET" && !mark.empty() && mark != now)
      return ErrorAnswer(409, "another project was opened; nothing was changed");
    return open->Handle(question);
  }

  static void ShowDoor(const char* words, httplib::Response& response) {
    response.set_header("Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'");
    response.set_content(ClosedDoor(words), "text/html; charset=utf-8");
  }

  std::string Address(const std::string& token) const {
    return fmt::format("http://127.0.0.1:{}/enter?token={}", port, token);
  }

  /// A browser that was let in goes on: an address that is opened again, or that was left open.
  void Enter(const httplib::Request& request, httplib::Response& response) {
    const auto cookie = guard->Enter(request.get_param_value("token"));
    if (!cookie && !guard->HasEntered(HeadOf(request))) {
      // Not by a link on somebody else's page.
      const bool asked =
          request.has_param("again") && request.get_header_value("Sec-Fetch-Site") != "cross-site";
      if (asked) PrintAgain();
      Refuse({403, "this address was used already; press Enter where it was printed for a new one"},
             response);
      if (WantsPage(request)) ShowDoor(asked ? kPrinted : kHowToEnter, response);
      return;
    }
    if (cookie) response.set_header("Set-Cookie", *cookie);
    response.set_redirect("/");
  }

  void PrintAgain() {
    constexpr auto kPause = std::chrono::seconds(10);
    const std::lock_guard<std::mutex> lock(mutex);
    const auto now = std::chrono::steady_clock::now();
    if (!print || now - printed < kPause) return;
    printed = now;
    print(Address(guard->NewToken()));
  }

  void SendEvents(httplib::Response& response) {
    const std::shared_ptr<Routes> open = door.Now();
    if (!open) return Refuse({404, "no project is open"}, response);
    auto tab = std::make_shared<EventHub::Tab>(open->hub());
    response.set_chunked_content_provider(
        "text/event-stream", [open, tab](std::size_t, httplib::DataSink& sink) {
          const std::string text = tab->Next();
          if (!text.empty()) return sink.write(text.data(), text.size());
          sink.done();  // the browser comes again, to the project that is open by then
          return true;
        });
  }

  const std::string session;
  std::mutex mutex;
  std::function<void(const std::string&)> print;
  std::function<void()> end;
  std::chrono::steady_clock::time_point printed;
  const std::vector<PageFile>& page;
  Door door;
  httplib::Server server;
  std::unique_ptr<Guard> guard;
  socket_t listener = INVALID_SOCKET;
  int port = 0;
};

StudioServer::StudioServer(const ServerOptions& options) : impl_(std::make_unique<Impl>(options)) {
  const std::string token = RandomDigits(128);
  impl_->guard = std::make_unique<Guard>(token, impl_->session, impl_->port);
  impl_->SetUp();
  address_ = impl_->Address(token);
}

std::string StudioServer::NewAddress() { return impl_->Address(impl_->guard->NewToken()); }

void StudioServer::OnAsked(std::function<void(const std::string&)> print) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->print = std::move(print);
  impl_->printed = std::chrono::steady_clock::now() - std::chrono::hours(1);
}

void StudioServer::OnEnd(std::function<void()> end) { impl_->end = std::move(end); }

fs::path StudioServer::folder() const { return impl_->door.Folder(); }

bool StudioServer::IsRunning() const {
  const std::shared_ptr<Routes> open = impl_->door.Now();
  return open && open->IsRunning();
}

StudioServer::~StudioServer() = default;

void StudioServer::Serve() { impl_->server.listen_after_bind(); }

void StudioServer::TellOthers() const {
  const nlohmann::json running = {
      {"pid", getpid()}, {"process", MarkOfProcess(getpid())}, {"port", impl_->port}};
  try {
    WriteFileAtomically(RunningFile(), running.dump());
  } catch (const Error&) {
    // then the next one is a second one
  }
}

std::string AddressOfRunning() {
  try {
    const auto running = nlohmann::json::parse(ReadFile(RunningFile()));
    // Only a program of this person's own is told the secret.
    const std::string process = running.at("process");
    if (process.empty() || process != MarkOfProcess(running.at("pid"))) return "";
    const int port = running.at("port");
    httplib::Client client("127.0.0.1", port);
    client.set_connection_timeout(2, 0);
    client.set_read_timeout(5, 0);
    const httplib::Headers headers = {
        {"Cookie", fmt::format("keypose_{}={}", port, ReadFile(UserStateFolder() / "session"))},
        {"X-Keypose", "1"}};
    const auto answer = client.Post("/api/door/address", headers, "{}", "application/json");
    if (!answer || answer->status != 200) return "";
    return nlohmann::json::parse(answer->body).at("address");
  } catch (const std::exception&) {
    return "";
  }
}

void StudioServer::Stop() {
  // Long enough for an answer that is being written.
  constexpr auto kLastWords = std::chrono::milliseconds(200);
  if (const auto open = impl_->door.Now()) open->hub().Close();
  impl_->server.stop();
  std::this_thread::sleep_for(kLastWords);
  ShutDownConnections(impl_->port);
}

}  // namespace keypose::studio
