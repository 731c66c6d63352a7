// SPDX-License-Identifier: GPL-2.0-only
/* STL files, text and binary. */

#include "triangle_mesh.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace granwave {
namespace {

constexpr std::size_t HEAD = 80, COUNTED = HEAD + 4, FACET = 50, NORMAL = 12;

std::vector<double> read_binary(const std::string &content, std::size_t n)
{
  std::vector<double> corners;
  corners.reserve(9 * n);
  for (std::size_t facet = 0; facet < n; facet++) {
    float numbers[9];
    std::memcpy(numbers, content.data() + COUNTED + facet * FACET + NORMAL, sizeof(numbers));
    corners.insert(corners.end(), numbers, numbers + 9);
  }
  return corners;
}

std::vector<double> read_text(const std::string &content)
{
  std::istringstream lines(content);
  std::vector<double> corners;
  std::string line;
  bool ended = false;
  for (int number = 1; std::getline(lines, line); number++) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    ended = word == "endsolid" || (ended && word.empty());
    const std::string where = "line " + std::to_string(number) + ": ";
    if (word == "endfacet" && corners.size() % 9)
      throw std::invalid_argument(where + "a facet has other than three vertices, expected triangles");
    if (word != "vertex") continue;
    for (int d = 0; d < 3; d++) {
      words >> word;
      char *rest = nullptr;
      const double value = words ? std::strtod(word.c_str(), &rest) : 0.0;
      if (!words || *rest) throw std::invalid_argument(where + "found \"" + line + "\", expected vertex X Y Z");
      corners.push_back(value);
    }
  }
  if (!ended || corners.size() % 9) throw std::invalid_argument("it is truncated: the last line is not endsolid");
  return corners;
}

}    // namespace

std::vector<double> read_stl(const std::string &content)
{
  std::uint32_t n = 0;
  if (content.size() >= COUNTED) {
    std::memcpy(&n, content.data() + HEAD, sizeof(n));
    if (content.size() == COUNTED + FACET * std::size_t(n)) return read_binary(content, n);
  }
  const std::size_t word = content.find_first_not_of(" \t\r\n");
  const bool is_text =
      word != std::string::npos && content.compare(word, 5, "solid") == 0 && content.find('\0') == std::string::npos;
  if (is_text) return read_text(content);
  if (content.size() >= COUNTED)
    throw std::invalid_argument("found " + std::to_string(content.size()) +
                                " bytes, expected an STL file: text from solid to endsolid, or binary, of " +
                                std::to_string(COUNTED + FACET * std::size_t(n)) + " bytes for the " + std::to_string(n) +
                                " triangles of its head");
  throw std::invalid_argument("found " + std::to_string(content.size()) +
                              " bytes, expected an STL file: text from solid to endsolid, or binary");
}

std::string content_of(const std::string &path)
{
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file) throw std::invalid_argument("cannot read " + path);
  return content.str();
}

}    // namespace granwave
