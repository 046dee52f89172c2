#include "interpolate/volume/run_tetgen.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#define TETLIBRARY
#include <tetgen.h>

#include "core/values/errors.h"

namespace keypose::interpolation {

namespace {

void Fill(tetgenio& in, const PointsX3& points, const FacesX3& faces) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(points.rows());
  in.pointlist = new REAL[points.size()];
  std::copy(points.data(), points.data() + points.size(), in.pointlist);
  in.numberoffacets = static_cast<int>(faces.rows());
  in.facetlist = new tetgenio::facet[faces.rows()];
  for (int f = 0; f < in.numberoffacets; ++f) {
    tetgenio::facet& facet = in.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3];
    for (int k = 0; k < 3; ++k) facet.polygonlist[0].vertexlist[k] = faces(f, k);
  }
}

bool WriteAll(int fd, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(fd, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

bool ReadAll(int fd, void* data, std::size_t size) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t got = read(fd, at, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

/// The child process. Nothing here takes a lock that another thread may have held at the fork;
/// malloc resets its own locks.
[[noreturn]] void Work(int out_fd, const PointsX3& points, const FacesX3& faces,
                       std::string switches, int time_limit_s) {
  const int nowhere = open("/dev/null", O_RDWR);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const rlimit no_core = {0, 0},
               time = {static_cast<rlim_t>(time_limit_s), static_cast<rlim_t>(time_limit_s)};
  setrlimit(RLIMIT_CORE, &no_core);
  setrlimit(RLIMIT_CPU, &time);
  tetgenio in, out;
  Fill(in, points, faces);
  try {
    tetrahedralize(switches.data(), &in, &out);
  } catch (...) {
    _exit(1);
  }
  const std::array<std::int32_t, 2> counts = {out.numberofpoints, out.numberoftetrahedra};
  const bool written =
      WriteAll(out_fd, counts.data(), sizeof(counts)) &&
      WriteAll(out_fd, out.pointlist, sizeof(double) * 3 * static_cast<std::size_t>(counts[0])) &&
      WriteAll(out_fd, out.tetrahedronlist,
               sizeof(int) * 4 * static_cast<std::size_t>(counts[1])) &&
      WriteAll(out_fd, out.neighborlist, sizeof(int) * 4 * static_cast<std::size_t>(counts[1]));
  _exit(written ? 0 : 1);
}

std::optional<TetgenMesh> Receive(int fd) {
  std::array<std::int32_t, 2> counts;
  if (!ReadAll(fd, counts.data(), sizeof(counts)) || counts[0] <= 0 || counts[1] <= 0)
    return std::nullopt;
  TetgenMesh mesh;
  mesh.points.resize(3 * static_cast<std::size_t>(counts[0]));
  mesh.tets.resize(4 * static_cast<std::size_t>(counts[1]));
  mesh.neighbours.resize(mesh.tets.size());
  if (!ReadAll(fd, mesh.points.data(), sizeof(double) * mesh.points.size()) ||
      !ReadAll(fd, mesh.tets.data(), sizeof(int) * mesh.tets.size()) ||
      !ReadAll(fd, mesh.neighbours.data(), sizeof(int) * mesh.neighbours.size()))
    return std::nullopt;
  return mesh;
}

}  // namespace

std::optional<TetgenMesh> RunTetgen(const PointsX3& points, const FacesX3& faces,
                                    const std::string& switches, int time_limit_s) {
  std::array<int, 2> ends;
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw ToolError(std::string("interpolate: no pipe to TetGen: ") + std::strerror(errno));
  const pid_t child = fork();
  if (child < 0) {
    const int fault = errno;
    close(ends[0]);
    close(ends[1]);
    throw ToolError(std::string("interpolate: TetGen's process cannot be started: ") +
                    std::strerror(fault));
  }
  if (child == 0) {
    close(ends[0]);
    Work(ends[1], points, faces, switches, time_limit_s);
  }
  close(ends[1]);
  std::optional<TetgenMesh> mesh = Receive(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  return mesh;
}

}  // namespace keypose::interpolation
