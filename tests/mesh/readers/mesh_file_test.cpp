// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/readers/mesh_file.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/readers/obj_reader.h"
#include "mesh/readers/ply_reader.h"
#include "mesh/readers/stl_reader.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using FaceList = std::vector<glm::uvec3>;
using Colors = std::vector<glm::u8vec3>;

TriangleSoup ply(std::string_view contents) {
  return parse_ply(contents, "m.ply");
}
TriangleSoup obj(std::string_view contents) {
  return parse_obj(contents, "m.obj");
}

void check_refused_ply(std::string_view contents, const std::string& sentence) {
  CHECK_THROWS_MATCHES(ply(contents), InputError, Catch::Message("m.ply: " + sentence));
}
void check_refused_obj(std::string_view contents, const std::string& sentence) {
  CHECK_THROWS_MATCHES(obj(contents), InputError, Catch::Message("m.obj: " + sentence));
}

// One number as a PLY body holds it.
struct Scalar {
  const char* type;
  double value;
};

template <typename Value>
std::string raw(Value value, std::endian endian) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (endian != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string raw(const Scalar& scalar, std::endian endian) {
  const std::string_view type = scalar.type;
  if (type == "char" || type == "int8") return raw(static_cast<std::int8_t>(scalar.value), endian);
  if (type == "uchar" || type == "uint8") return raw(static_cast<std::uint8_t>(scalar.value), endian);
  if (type == "short" || type == "int16") return raw(static_cast<std::int16_t>(scalar.value), endian);
  if (type == "ushort" || type == "uint16") return raw(static_cast<std::uint16_t>(scalar.value), endian);
  if (type == "int" || type == "int32") return raw(static_cast<std::int32_t>(scalar.value), endian);
  if (type == "uint" || type == "uint32") return raw(static_cast<std::uint32_t>(scalar.value), endian);
  if (type == "float" || type == "float32") return raw(static_cast<float>(scalar.value), endian);
  return raw(scalar.value, endian);
}

enum class Encoding { Ascii, Little, Big };
const std::vector<Encoding> kEncodings{Encoding::Ascii, Encoding::Little, Encoding::Big};

// A PLY file record by record.
class PlyFile {
 public:
  explicit PlyFile(Encoding encoding) : encoding_(encoding) {}

  PlyFile& declare(const std::string& line) {
    header_ += line + "\n";
    return *this;
  }
  PlyFile& record(const std::vector<Scalar>& scalars) {
    for (const Scalar& scalar : scalars) {
      char text[64];
      std::snprintf(text, sizeof text, "%.17g ", scalar.value);
      body_ += encoding_ == Encoding::Ascii
                   ? std::string(text)
                   : raw(scalar, encoding_ == Encoding::Big ? std::endian::big : std::endian::little);
    }
    if (encoding_ == Encoding::Ascii) body_.back() = '\n';
    return *this;
  }
  [[nodiscard]] std::string bytes() const {
    const char* const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    return std::string("ply\nformat ") + names[static_cast<int>(encoding_)] + " 1.0\n" + header_ + "end_header\n" +
           body_;
  }

 private:
  Encoding encoding_;
  std::string header_, body_;
};

// Four corners of a unit square in the plane z = 2, whose properties have the given type.
PlyFile square(Encoding encoding, const char* type = "float") {
  PlyFile file(encoding);
  file.declare("element vertex 4");
  for (const char* const name : {"x", "y", "z"}) file.declare(std::string("property ") + type + " " + name);
  file.declare("element face 1").declare("property list uchar int vertex_indices");
  for (const glm::dvec2 corner : {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(1, 1), glm::dvec2(0, 1)}) {
    file.record({{type, corner.x}, {type, corner.y}, {type, 2}});
  }
  return file.record({{"uchar", 4}, {"int", 0}, {"int", 1}, {"int", 2}, {"int", 3}});
}

const std::vector<glm::dvec3> kSquare{{0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {0, 1, 2}};

// The contents of a PLY with three vertices, coloured, and one triangle.
std::string colored_ply(Encoding encoding, const char* type, double red, double green, double blue,
                        const std::string& prefix = "") {
  PlyFile file(encoding);
  file.declare("element vertex 3");
  for (const char* const name : {"x", "y", "z"}) file.declare(std::string("property float ") + name);
  for (const char* const name : {"red", "green", "blue"}) {
    file.declare(std::string("property ") + type + " " + prefix + name);
  }
  file.declare("element face 1").declare("property list uchar int vertex_indices");
  for (const double x : {0, 1, 2}) {
    file.record({{"float", x}, {"float", x * x}, {"float", 0}, {type, red}, {type, green}, {type, blue}});
  }
  return file.record({{"uchar", 3}, {"int", 0}, {"int", 1}, {"int", 2}}).bytes();
}

// An ASCII PLY with three vertices at (0,0,0), (1,0,0), (0,1,0) and these face records.
std::string triangle_with_faces(const std::string& count, const std::string& records,
                                const std::string& list = "uchar int vertex_indices") {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
         "face " +
         count + "\nproperty list " + list + "\nend_header\n0 0 0\n1 0 0\n0 1 0\n" + records;
}

TEST_CASE("PLY: positions of every scalar type in every encoding") {
  const Encoding encoding = GENERATE(from_range(kEncodings));
  const char* const type = GENERATE("char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8",
                                    "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64");
  const TriangleSoup soup = ply(square(encoding, type).bytes());
  CHECK(soup.positions == kSquare);
  CHECK(soup.colors.empty());
  CHECK(soup.faces == FaceList{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("PLY: double positions far from the origin are kept to the last bit") {
  const Encoding encoding = GENERATE(from_range(kEncodings));
  PlyFile file(encoding);
  file.declare("element vertex 1");
  for (const char* const name : {"x", "y", "z"}) file.declare(std::string("property double ") + name);
  file.declare("element face 1").declare("property list uchar int vertex_indices");
  file.record({{"double", 4599999.987654321}, {"double", -1234567.1000000001}, {"double", 5e-324}});
  file.record({{"uchar", 3}, {"int", 0}, {"int", 0}, {"int", 0}});
  CHECK(ply(file.bytes()).positions[0] == glm::dvec3(4599999.987654321, -1234567.1000000001, 5e-324));
}

TEST_CASE("PLY: elements and properties that are not asked for are skipped") {
  const Encoding encoding = GENERATE(from_range(kEncodings));
  PlyFile file(encoding);
  file.declare("comment made by hand").declare("obj_info end_header is not here").declare("element camera 1");
  file.declare("property list uint double pose").declare("property char on");
  file.declare("element nothing 9223372036854775807");
  file.declare("element face 2").declare("property uchar material");
  file.declare("property list ushort uint vertex_index").declare("property list uchar float texcoord");
  file.declare("element vertex 3").declare("property float z").declare("property list int short seen_by");
  file.declare("property double y").declare("property short x").declare("property float confidence");
  file.declare("element edge 1").declare("property int vertex1").declare("property int vertex2");
  file.record({{"uint", 2}, {"double", 1.5}, {"double", 2.5}, {"char", -1}});
  file.record({{"uchar", 7}, {"ushort", 3}, {"uint", 2}, {"uint", 1}, {"uint", 0}, {"uchar", 1}, {"float", 0.5}});
  file.record({{"uchar", 7}, {"ushort", 3}, {"uint", 0}, {"uint", 1}, {"uint", 2}, {"uchar", 0}});
  for (const double x : {1, 2, 3}) {
    file.record(
        {{"float", x + 0.5}, {"int", 2}, {"short", 4}, {"short", 5}, {"double", -x}, {"short", x}, {"float", 9}});
  }
  file.record({{"int", 0}, {"int", 1}});
  const TriangleSoup soup = ply(file.bytes());
  CHECK(soup.positions == std::vector<glm::dvec3>{{1, -1, 1.5}, {2, -2, 2.5}, {3, -3, 3.5}});
  CHECK(soup.faces == FaceList{{2, 1, 0}, {0, 1, 2}});
}

TEST_CASE("PLY: polygons become fans, and one or two corners a degenerate triangle") {
  CHECK(ply(triangle_with_faces("3", "5 0 1 2 1 0\n2 1 2\n1 2\n")).faces ==
        FaceList{{0, 1, 2}, {0, 2, 1}, {0, 1, 0}, {1, 2, 2}, {2, 2, 2}});
}

TEST_CASE("PLY and OBJ: a concave polygon is not cut into a fan, also if its vertices come after it") {
  const auto area = [](const TriangleSoup& soup) {
    double sum = 0;
    for (const glm::uvec3& face : soup.faces) {
      const glm::dvec3& a = soup.positions[face.x];
      sum += glm::length(glm::cross(soup.positions[face.y] - a, soup.positions[face.z] - a)) / 2;
    }
    return sum;
  };
  const std::string dart = "1 0 0\n0 1 0\n-1 0 0\n0 0.2 0\n";
  const std::string vertex = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string start = "ply\nformat ascii 1.0\n", end = "end_header\n";
  CHECK(area(ply(start + vertex + face + end + dart + "4 0 1 2 3\n")) == Approx(0.8));
  CHECK(area(ply(start + face + vertex + end + "4 0 1 2 3\n" + dart)) == Approx(0.8));
  CHECK(area(obj("f 1 2 3 4\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 0.2 0\n")) == Approx(0.8));
}

TEST_CASE("PLY: bytes that the header does not declare are refused, except empty lines and padding") {
  CHECK(ply(triangle_with_faces("1", "3 0 1 2\n \r\n\n")).faces.size() == 1);
  check_refused_ply(triangle_with_faces("1", "3 0 1 2\n3 0 2 1\n"),
                    "8 bytes follow after all records that its header declares, 3 of 'vertex' and 1 of 'face'; the "
                    "header is wrong or the file damaged");
  const std::string bytes = square(GENERATE(Encoding::Little, Encoding::Big)).bytes();
  CHECK(ply(bytes + "\n").faces.size() == 2);
  CHECK(ply(bytes + std::string(3, '\0')).faces.size() == 2);
  check_refused_ply(bytes + std::string(1, '\x04') + std::string(16, '\0'),
                    "17 bytes follow after all records that its header declares, 4 of 'vertex' and 1 of 'face'; the "
                    "header is wrong or the file damaged");
}

TEST_CASE("PLY: the sentence about bytes that no record takes stays short, however many elements are declared") {
  std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  header += "element face 1\nproperty list uchar int vertex_indices\n";
  for (int i = 0; i < 50; ++i) header += "element nothing" + std::to_string(i) + " 0\n";
  check_refused_ply(header + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\nrest\n",
                    "5 bytes follow after all records that its header declares, 3 of 'vertex' and 1 of 'face' and 0 of "
                    "'nothing0' and more; the header is wrong or the file damaged");
}

TEST_CASE("PLY: vertex numbers of every type") {
  const char* const type = GENERATE("char", "ushort", "uint", "float", "double");
  const Encoding encoding = GENERATE(from_range(kEncodings));
  PlyFile file(encoding);
  file.declare("element vertex 3").declare("property float x").declare("property float y").declare("property float z");
  file.declare("element face 1").declare(std::string("property list int ") + type + " vertex_indices");
  for (int i = 0; i < 3; ++i) file.record({{"float", 0}, {"float", 0}, {"float", 0}});
  file.record({{"int", 3}, {type, 0}, {type, 2}, {type, 1}});
  CHECK(ply(file.bytes()).faces == FaceList{{0, 2, 1}});
}

TEST_CASE("PLY: colours of every type") {
  const Encoding encoding = GENERATE(from_range(kEncodings));
  const Colors expected(3, glm::u8vec3(255, 128, 0));
  CHECK(ply(colored_ply(encoding, "uchar", 255, 128, 0)).colors == expected);
  CHECK(ply(colored_ply(encoding, "int", 255, 128, 0)).colors == expected);
  CHECK(ply(colored_ply(encoding, "ushort", 65535, 128 * 257, 128)).colors == expected);
  CHECK(ply(colored_ply(encoding, "float", 1, 0.5, 0.001)).colors == expected);
  CHECK(ply(colored_ply(encoding, "double", 1, 0.5, 0)).colors == expected);
  CHECK(ply(colored_ply(encoding, "uchar", 255, 128, 0, "diffuse_")).colors == expected);
  CHECK(ply(colored_ply(encoding, "uchar", 255, 128, 0, "other_")).colors.empty());
}

TEST_CASE("PLY: a colour beyond its type's range is refused") {
  check_refused_ply(colored_ply(Encoding::Little, "float", 0.5, 128, 0),
                    "vertex 0 has green 128, which is not in [0, 1]");
  check_refused_ply(colored_ply(Encoding::Big, "int", 0, 255, -1), "vertex 0 has blue -1, which is not in [0, 255]");
  check_refused_ply(colored_ply(Encoding::Little, "double", std::nan(""), 0, 0),
                    "vertex 0 has red nan, which is not in [0, 1]");
}

std::string with_line_ends(std::string text, const std::string& line_end) {
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + line_end.size())) {
    text.replace(at, 1, line_end);
  }
  return text;
}

TEST_CASE("PLY: line ends of every system, in headers and ASCII bodies") {
  const std::string line_end = GENERATE("\n", "\r\n", "\r");
  CHECK(ply(with_line_ends(square(Encoding::Ascii).bytes(), line_end)).positions == kSquare);
  const std::string binary = square(Encoding::Big).bytes();
  const std::size_t body = binary.find("end_header\n") + 11;
  CHECK(ply(with_line_ends(binary.substr(0, body), line_end) + binary.substr(body)).positions == kSquare);
}

TEST_CASE("PLY: a binary body may begin with a line feed after a header with CRLF") {
  PlyFile file(Encoding::Little);
  file.declare("element vertex 1").declare("property char x").declare("property char y").declare("property char z");
  file.declare("element face 1").declare("property list uchar char vertex_index");
  file.record({{"char", 10}, {"char", 13}, {"char", 10}}).record({{"uchar", 1}, {"char", 0}});
  const std::string bytes = file.bytes();
  const std::size_t body = bytes.find("end_header\n") + 11;
  for (const char* const line_end : {"\n", "\r\n", "\r"}) {
    CHECK(ply(with_line_ends(bytes.substr(0, body), line_end) + bytes.substr(body)).positions[0] ==
          glm::dvec3(10, 13, 10));
  }
}

TEST_CASE("PLY: positions that are not finite are kept for repair() to count") {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\nnan 0 +1e999\n-inf 1e-999 -2.5\n0 1 0\n3 0 1 2";
  const TriangleSoup soup = ply(text);
  CHECK(std::isnan(soup.positions[0].x));
  CHECK(soup.positions[0].z == INFINITY);
  CHECK(soup.positions[1] == glm::dvec3(-INFINITY, 0, -2.5));
}

TEST_CASE("PLY: blank lines and tabs between ASCII records are nothing") {
  CHECK(ply(triangle_with_faces("1", "\n \t\n\t3  0\t1 2 \n\n")).faces == FaceList{{0, 1, 2}});
}

TEST_CASE("PLY: a file that is cut off is refused at any length") {
  const std::string bytes = square(GENERATE(from_range(kEncodings))).bytes();
  const std::size_t complete = bytes.back() == '\n' ? bytes.size() - 1 : bytes.size();  // ASCII needs no last line feed
  for (std::size_t length = 0; length < complete; ++length) {
    CAPTURE(length);
    CHECK_THROWS_AS(ply(bytes.substr(0, length)), InputError);
  }
}

TEST_CASE("PLY: any byte changed gives valid faces or a sentence") {
  const std::string bytes = square(GENERATE(from_range(kEncodings))).bytes();
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(~changed[at]);
    CAPTURE(at);
    try {
      for (const glm::uvec3& face : ply(changed).faces) CHECK(std::max({face.x, face.y, face.z}) < 4);
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Catch::StartsWith("m.ply: ") && !Catch::Contains("\n"));
    }
  }
}

TEST_CASE("PLY: what is wrong with a header is said with its line") {
  const std::string start = "ply\nformat ascii 1.0\n";
  check_refused_ply("", "not a PLY file, its first line is not 'ply'");
  check_refused_ply("plywood\n", "not a PLY file, its first line is not 'ply'");
  check_refused_ply("ply\n", "PLY header line 2: the file ends before 'end_header'; it is cut off");
  check_refused_ply("ply\nend_header\n", "PLY header line 2: the line 'format ...' is missing");
  check_refused_ply("ply\nformat binary 1.0\n",
                    "PLY header line 2: the format 'binary' is not ascii, binary_little_endian or binary_big_endian");
  check_refused_ply("ply\nformat ascii 2.0\n", "PLY header line 2: the version '2.0' is not 1.0");
  check_refused_ply(start + "elephant 3\n", "PLY header line 3: 'elephant' is not a keyword of a PLY header");
  check_refused_ply(start + std::string(50, 'a') + "\n",
                    "PLY header line 3: '" + std::string(40, 'a') + "...' is not a keyword of a PLY header");
  check_refused_ply(start + "\x01\x80\n", "PLY header line 3: '?\?' is not a keyword of a PLY header");
  check_refused_ply(start + "element vertex -1\n",
                    "PLY header line 3: 'element' needs a name and a count, not 'vertex' and '-1'");
  check_refused_ply(start + "element vertex\n",
                    "PLY header line 3: 'element' needs a name and a count, not 'vertex' and ''");
  check_refused_ply(start + "element vertex 99999999999999999999\n",
                    "PLY header line 3: 'element' needs a name and a count, not 'vertex' and '99999999999999999999'");
  check_refused_ply(start + "element vertex 1\nelement vertex 1\n",
                    "PLY header line 4: the element 'vertex' was declared before");
  check_refused_ply(start + "property float x\n", "PLY header line 3: a property comes before any element");
  check_refused_ply(start + "element vertex 1\nproperty long x\n",
                    "PLY header line 4: the type 'long' is not one of PLY's");
  check_refused_ply(start + "element vertex 1\nproperty float\n", "PLY header line 4: a property has no name");
  check_refused_ply(start + "element vertex 1\nproperty float x\nproperty int x\n",
                    "PLY header line 5: the property 'x' was declared before");
  check_refused_ply(start + "element face 1\nproperty list float int vertex_indices\n",
                    "PLY header line 4: a list is counted in floating point");
}

TEST_CASE("PLY: a file that holds no mesh is refused with advice") {
  const std::string start = "ply\nformat ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string no_faces =
      "has no faces; a point cloud must be meshed first, for instance by Poisson reconstruction";
  check_refused_ply(start + "end_header\n", "has no vertices");
  check_refused_ply(start + "element vertex 1\n" + xyz + "end_header\n1 2 3\n", no_faces);
  check_refused_ply(triangle_with_faces("0", ""), no_faces);
  check_refused_ply(start + "element vertex 1\nproperty float x\nproperty float y\nelement face 1\n" +
                        "property list uchar int vertex_indices\nend_header\n0 0\n3 0 0 0\n",
                    "its element 'vertex' lacks one of the numbers x, y and z");
  check_refused_ply(triangle_with_faces("1", "3 0 1 2\n", "uchar int corners"),
                    "its element 'face' has no list vertex_indices");
  check_refused_ply(start + "element vertex 5000000000\n" + xyz + "element face 1\nend_header\n",
                    "has 5000000000 vertices, more than 4294967295");
}

TEST_CASE("PLY: claims that the file cannot hold are refused before anything is allocated") {
  const Encoding encoding = GENERATE(Encoding::Little, Encoding::Big);
  const auto claim = [&](const std::string& vertices, const std::string& faces) {
    PlyFile file(encoding);
    file.declare("element vertex " + vertices);
    for (const char* const name : {"x", "y", "z"}) file.declare(std::string("property float ") + name);
    file.declare("element face " + faces).declare("property list uint int vertex_indices");
    file.record({{"float", 0}, {"float", 0}, {"float", 0}});
    return file.record({{"uint", 4000000000}, {"int", 0}, {"int", 0}, {"int", 0}}).bytes();
  };
  check_refused_ply(claim("4294967295", "1"),
                    "its header claims 4294967295 records of 'vertex', too many for the 28 bytes that follow; the file "
                    "is cut off or damaged");
  check_refused_ply(claim("1", "9223372036854775807"),
                    "its header claims 9223372036854775807 records of 'face', too many for the 28 bytes that follow; "
                    "the file is cut off or damaged");
  check_refused_ply(claim("1", "1"), "face 0 of 1 is not complete; the file is cut off or damaged");
  check_refused_ply(triangle_with_faces("4000000000", "3 0 1 2\n"),
                    "its header claims 4000000000 records of 'face', too many for the 26 bytes that follow; the file "
                    "is cut off or damaged");
  check_refused_ply(triangle_with_faces("1", "4000000000 0 1 2\n", "uint int vertex_indices"),
                    "face 0 has too few values on its line");
}

TEST_CASE("PLY: what is wrong with a record is said with its number") {
  check_refused_ply(triangle_with_faces("2", "3 0 1 2\n3 0 1 3\n"),
                    "face 1 refers to vertex 3, but there are 3 vertices, counted from 0");
  check_refused_ply(triangle_with_faces("1", "3 0 -1 2\n"),
                    "face 0 refers to vertex -1, but there are 3 vertices, counted from 0");
  check_refused_ply(triangle_with_faces("1", "3 0 0.5 2\n", "uchar float vertex_indices"),
                    "face 0 refers to vertex 0.5, but there are 3 vertices, counted from 0");
  check_refused_ply(triangle_with_faces("1", "3 0 nan 2\n", "uchar float vertex_indices"),
                    "face 0 refers to vertex nan, but there are 3 vertices, counted from 0");
  check_refused_ply(triangle_with_faces("1", "3 0 0.5 2\n"), "face 0 has the value '0.5', which is not a whole number");
  check_refused_ply(triangle_with_faces("1", "3 0 1x 2\n"), "face 0 has the value '1x', which is not a number");
  check_refused_ply(triangle_with_faces("1", "3 0 1\n"), "face 0 has too few values on its line");
  check_refused_ply(triangle_with_faces("1", "3 0 1 2 0\n"),
                    "face 0 has more values on its line than the header declares");
  check_refused_ply(triangle_with_faces("1", "0\n  "), "face 0 has no corners");
  check_refused_ply(triangle_with_faces("1", "-1\n  "), "face 0 has a list 'vertex_indices' of -1 items");
  check_refused_ply(triangle_with_faces("2", "3 0 1 2\n"), "face 1 of 2 is missing; the file is cut off or damaged");
  check_refused_ply(
      "ply\nformat ascii 1.0\nelement a\x01 1\nproperty int b\nelement vertex 1\nelement face 1\n"
      "end_header\nx\n",
      "'a?' 0 has the value 'x', which is not a number");
}

TEST_CASE("OBJ: vertices and faces in all their forms") {
  const TriangleSoup soup = obj(
      "# a comment\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\n\tv\t+1 1e0 0 # last\nvt 0 0\nvn 0 0 1\nusemtl \\\n"
      "f 1 2 3\nf 1/1 2/1 3/1\r\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\nf 1 2 3 1 2\nf 1 2\nl 1 2\nf 4 1 "
      "2\n"
      "v 9 9 9");
  CHECK(soup.positions == std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {9, 9, 9}});
  CHECK(soup.colors.empty());
  CHECK(soup.faces == FaceList{{0, 1, 2},
                               {0, 1, 2},
                               {0, 1, 2},
                               {0, 1, 2},
                               {0, 1, 2},
                               {2, 0, 1},  // corners that repeat are nothing
                               {0, 0, 0},
                               {0, 0, 0},
                               {0, 1, 1},
                               {3, 0, 1}});
}

TEST_CASE("OBJ: a statement goes on after a backslash, and the lines are still counted") {
  const std::string start = "v 0 0 0\nv 1 0 \\\n 0\nv 0 1 0\nf 1 \\\r\n2 \\\n\\\n3\n";
  CHECK(obj(start).faces == FaceList{{0, 1, 2}});
  check_refused_obj(start + "f 1 2 x\n",
                    "line 9: a face has the corner 'x', which does not begin with a vertex number");
}

TEST_CASE("OBJ: positions are the nearest double, also those that are not finite") {
  const TriangleSoup soup = obj("v 4599999.987654321 -1234567.123456789 0.3\nv nan -inf 1e999\nf 1 2 1\n");
  CHECK(soup.positions[0] == glm::dvec3(4599999.987654321, -1234567.123456789, 0.3));
  CHECK(std::isnan(soup.positions[1].x));
  CHECK(soup.positions[1].y == -INFINITY);
  CHECK(soup.positions[1].z == INFINITY);
}

TEST_CASE("OBJ: colours after the position, with and without a weight") {
  const Colors orange(2, glm::u8vec3(255, 128, 0));
  CHECK(obj("v 0 0 0 1 .5 0\nv 0 1 0 1 0.5 0.001\nf 1 2 1\n").colors == orange);
  CHECK(obj("v 0 0 0 1 1 .5 0\nv 0 1 0 1 1 0.5 0.001\nf 1 2 1\n").colors == orange);
}

TEST_CASE("OBJ: the most numbers of any vertex tell what they are, weights and opacities are left out") {
  const std::string faces = "f 1 2 3\n";
  const Colors red(3, glm::u8vec3(255, 0, 0));
  const auto of = [&](const std::string& after) { return obj(after + after + after + faces); };
  CHECK(of("v 0 0 0\n").colors.empty());
  CHECK(of("v 0 0 0 1\n").colors.empty());
  CHECK(of("v 0 0 0 1 0 0\n").colors == red);
  CHECK(of("v 0 0 0 1 1 0 0\n").colors == red);                          // x y z w r g b
  CHECK(of("v 0 0 0 1 1 0 0 0.5\n").colors == red);                      // x y z w r g b a
  CHECK(of("v 0 0 0 1 1 1 1\n").colors == Colors(3, glm::u8vec3(255)));  // white in either way
  // Opaque and of several colours: the last number is 1 everywhere, the fourth is not.
  CHECK(obj("v 0 0 0 1 0 0 1\nv 0 0 0 0 1 0 1\nv 0 0 0 0.2 0 1 1\n" + faces).colors ==
        Colors{{255, 0, 0}, {0, 255, 0}, {51, 0, 255}});
  // Half transparent: a weight would be 1.
  CHECK(obj("v 0 0 0 1 0 0 0.5\nv 0 0 0 0 1 0 0.4\nv 0 0 0 0.2 0 1 0.5\n" + faces).colors ==
        Colors{{255, 0, 0}, {0, 255, 0}, {51, 0, 255}});
  CHECK(obj("v 0 0 0 1 1 0 0\nv 0 0 0 1 0 1 0\nv 0 0 0 1 0 0 1\n" + faces).colors ==
        Colors{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}});
}

TEST_CASE("OBJ: seven numbers that may be a weight or an opacity are refused, mixtures too") {
  check_refused_obj(
      "v 0 0 0 1 1 1 1\nv 0 0 0 1 0 0 1\nv 0 0 0 1 0.5 0 1\nf 1 2 3\n",
      "its vertices have 7 numbers, of which the fourth and the last are 1 everywhere: this may be x y z w "
      "r g b or x y z r g b a; write x y z r g b");
  check_refused_obj("v 0 0 0 1\nv 0 0 0 1 0 0\nf 1 2 1\n",
                    "line 2: a vertex has 6 numbers, the first has 4: give all the same");
  check_refused_obj("v 0 0 0\nv 0 0 0 1 1 0 0\nf 1 2 1\n",
                    "line 2: a vertex has 7 numbers, the first has 3: give all the same");
  check_refused_obj("v 0 0 0 2\nf 1 1 1\n", "line 1: a vertex has the weight 2, must be 1: write x y z divided by it");
}

TEST_CASE("OBJ: statements that make surfaces in other ways are refused, other words too") {
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const char* const word :
       {"surf", "curv", "curv2", "cstype", "deg", "parm", "trim", "bzp", "bsp", "cdc", "res"}) {
    check_refused_obj(start + word + " 1 2\n", "line 5: begins with '" + std::string(word) +
                                                   "', a free-form surface, which this program does not read: convert "
                                                   "it to triangles");
  }
  check_refused_obj(start + "call other.obj\n",
                    "line 5: begins with 'call', which takes in another file, which this program does not read: write "
                    "one file");
  check_refused_obj(start + "F 1 2 3\n", "line 5: begins with 'F', which is no word of OBJ");
  CHECK(obj(start + "l 1 \\\n2 3 \\\n1\nusemtl a\\\nf 1 2 3\n").faces.size() == 2);
  CHECK(obj(start + "fo 1 2 3\n").faces.size() == 2);  // as version 2.11 has faces
  CHECK(obj(start +
            "vp 1\np 1\nl 1 2\nvt 0 0\nvn 0 0 1\ng a\no b\ns 1\nmg 1 2\nusemtl a\nmtllib b\nusemap c\nmaplib d\n"
            "bevel on\nc_interp on\nd_interp on\nlod 1\nshadow_obj a\ntrace_obj b\nctech a\nstech b\n")
            .faces.size() == 1);
}

// Six vertices and a list of strips, in ASCII or in binary.
std::string strips_ply(const char* format, const char* index_type, const std::vector<std::int64_t>& list) {
  const std::string type = index_type;
  std::string text = std::string("ply\nformat ") + format +
                     " 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
                     "element tristrips 1\nproperty list int " +
                     type + " vertex_indices\nend_header\n";
  const bool is_ascii = std::string_view(format) == "ascii";
  const std::endian endian = std::string_view(format) == "binary_big_endian" ? std::endian::big : std::endian::little;
  for (int i = 0; i < 6; ++i) {
    if (is_ascii) text += std::to_string(i) + " 0 0\n";
    if (!is_ascii) text += raw(static_cast<float>(i), endian) + raw(0.0F, endian) + raw(0.0F, endian);
  }
  text += is_ascii ? std::to_string(list.size()) : raw(static_cast<std::int32_t>(list.size()), endian);
  for (const std::int64_t index : list) {
    if (is_ascii) text += " " + std::to_string(index);
    if (!is_ascii && type == "short") text += raw(static_cast<std::int16_t>(index), endian);
    if (!is_ascii && type != "short") text += raw(static_cast<std::int32_t>(index), endian);
  }
  return text + (is_ascii ? "\n" : "");
}

TEST_CASE("PLY: triangle strips turn round every second triangle, end at -1 and may repeat vertices") {
  // A strip of three triangles, one that is too short, one led on by a repeated vertex, and one that does not end.
  const std::vector<std::int64_t> list{0, 1, 2, 3, 4, -1, 5, 4, -1, -1, 0, 1, 2, 2, 3, 5, -1, 5, 1, 0};
  const FaceList expected{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {0, 1, 2}, {3, 2, 5}, {5, 1, 0}};
  for (const char* const format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* const type : {"int", "short"}) CHECK(ply(strips_ply(format, type, list)).faces == expected);
  }
  std::vector<std::int64_t> without_sign = list;
  std::replace(without_sign.begin(), without_sign.end(), std::int64_t{-1}, std::int64_t{4294967295});
  CHECK(ply(strips_ply("ascii", "uint", without_sign)).faces == expected);
  CHECK(ply(strips_ply("binary_big_endian", "uint", without_sign)).faces == expected);
}

TEST_CASE("PLY: triangle strips are added to faces") {
  const std::string text =
      "ply\nformat ascii 1.0\nelement tristrips 2\nproperty uchar id\nproperty list int int vertex_index\n"
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list int int vertex_indices\nend_header\n7 3 0 1 2\n8 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
      "3 2 1 3\n";
  CHECK(ply(text).faces == FaceList{{0, 1, 2}, {2, 1, 3}});
}

TEST_CASE("PLY: triangle strips that are damaged are refused by index") {
  check_refused_ply(strips_ply("ascii", "int", {0, 1, 2, 6}),
                    "'tristrips' 0 refers to vertex 6 at index 3, but there are 6 vertices, counted from 0");
  check_refused_ply(strips_ply("binary_little_endian", "int", {0, 1, -2, 3}),
                    "'tristrips' 0 refers to vertex -2 at index 2, but there are 6 vertices, counted from 0");
  const std::string no_faces =
      "has no faces; a point cloud must be meshed first, for instance by Poisson reconstruction";
  check_refused_ply(strips_ply("ascii", "int", {0, 1, -1, 2, 3}), no_faces);
  check_refused_ply(strips_ply("ascii", "int", {}), no_faces);
  std::string cut_off = strips_ply("binary_little_endian", "int", {0, 1, 2, 3});
  cut_off.resize(cut_off.size() - 1);
  check_refused_ply(cut_off, "'tristrips' 0 of 1 is not complete; the file is cut off or damaged");
  check_refused_ply(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int strips\nend_header\n0 0 0\n3 0 0 0\n",
      "its element 'tristrips' has no list vertex_indices");
}

TEST_CASE("OBJ: what is wrong is said with its line") {
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  check_refused_obj("hello\n", "line 1: begins with 'hello', which is no word of OBJ");
  check_refused_obj("# nothing\n", "has no vertices");
  check_refused_obj(start, "has no faces; a point cloud must be meshed first, for instance by Poisson reconstruction");
  check_refused_obj("v 0 0\n", "line 1: a vertex has 2 numbers; 3, 4, 6, 7 or 8 are known");
  check_refused_obj("v 0 0 0 0 0\n", "line 1: a vertex has 5 numbers; 3, 4, 6, 7 or 8 are known");
  check_refused_obj("v 0 0 0 1 1 1 1 1 1\n", "line 1: a vertex has more than 8 numbers");
  check_refused_obj("\nv 0 0,5 0\n", "line 2: a vertex has the value '0,5', which is not a number");
  check_refused_obj("v 0 0 0 1 2 1\n", "line 1: a vertex has a colour outside of [0, 1]");
  check_refused_obj("v 0 0 0 nan 0 0\n", "line 1: a vertex has a colour outside of [0, 1]");
  check_refused_obj(start + "v 0 0 0 1 1 1\n", "line 4: a vertex has 6 numbers, the first has 3: give all the same");
  check_refused_obj("v 0 0 0 1 1 1\nv 0 0 0\n", "line 2: a vertex has 3 numbers, the first has 6: give all the same");
  check_refused_obj(start + "f\n", "line 4: a face has no corners");
  check_refused_obj(start + "f 1 2 0\n", "line 4: a face refers to vertex 0, but there are 3 vertices, counted from 1");
  check_refused_obj(start + "f 1 2 -4\n",
                    "line 4: a face refers to vertex -4, but there are 3 vertices, counted from 1");
  check_refused_obj(start + "f 1 2 3\nf 1 2 5\nf 1 2 6\nf 1 5 6\nv 0 0 0\n",
                    "line 6: a face refers to vertex 6, but there are 4 vertices, counted from 1");
  check_refused_obj(start + "f 1 2 4294967296\n",
                    "line 4: a face refers to vertex 4294967296, but there are 3 vertices, counted from 1");
  check_refused_obj(start + "f 1 2 99999999999999999999\n",
                    "line 4: a face has the corner '99999999999999999999', which does not begin with a vertex number");
  check_refused_obj(start + "f /1 2 3\n",
                    "line 4: a face has the corner '/1', which does not begin with a vertex number");
}

TEST_CASE("OBJ: any byte changed gives valid faces or a sentence") {
  const std::string bytes = "v 0 0 0 .1 .2 .3\nv 1 0 \\\n0 1 1 1\nv 1 1 0 0 0 0\nf 1/1 2//2 -1\nf 3 \\\n2 1 1\n";
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (int value = 0; value < 256; ++value) {
      std::string changed = bytes;
      changed[at] = static_cast<char>(value);
      try {
        const TriangleSoup soup = obj(changed);
        for (const glm::uvec3& face : soup.faces) REQUIRE(std::max({face.x, face.y, face.z}) < soup.positions.size());
      } catch (const InputError& error) {
        REQUIRE_THAT(error.what(), Catch::StartsWith("m.obj: ") && !Catch::Contains("\n"));
      }
    }
  }
}

// Two triangles that share an edge, as binary STL with `count` in its header.
std::string binary_stl(const std::string& header, std::uint32_t count = 2) {
  std::string bytes = header + std::string(80 - header.size(), ' ');
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& corners : {std::array<float, 9>{0, 0, 0, 1, 0, 0, 0, 1.5f, 0}, {1, 0, 0, 1, 1, 0, 0, 1.5f, 0}}) {
    const std::array<float, 3> normal{0, 0, 1};
    bytes.append(reinterpret_cast<const char*>(normal.data()), 12);
    bytes.append(reinterpret_cast<const char*>(corners.data()), 36);
    bytes.append("\x12\x34", 2);
  }
  return bytes;
}

const std::string kAsciiStl =
    "solid two words\r\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1.5e0 0\n"
    "  endloop\n endfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 -0\nvertex +1 1 0\nvertex 0 1.5 0\nendloop\n"
    "endfacet\nendsolid";

TEST_CASE("STL: corners at the same place are one vertex, in binary and ASCII files alike") {
  // Some programs begin binary files with "solid" too.
  std::string upper = kAsciiStl;
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  const std::string indented = " \t\r\n  " + kAsciiStl, marked = "\xef\xbb\xbf" + kAsciiStl;
  for (const std::string& contents : {binary_stl("made by hand"), binary_stl("solid"), binary_stl("SOLID a"),
                                      binary_stl("  solid"), kAsciiStl, upper, indented, marked}) {
    const TriangleSoup soup = parse_stl(contents, "m.stl");
    CHECK(soup.positions == std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1.5, 0}, {1, 1, 0}});
    CHECK(soup.faces == FaceList{{0, 1, 2}, {1, 3, 2}});
    CHECK(soup.colors.empty());
  }
}

TEST_CASE("STL: what is damaged is refused by line or length, and what is not a number stays for the repair") {
  const auto refused = [](const std::string& contents) -> std::string {
    try {
      (void)parse_stl(contents, "m.stl");
    } catch (const InputError& error) {
      return error.what();
    }
    return "taken";
  };
  const std::string neither = "m.stl: is neither ASCII STL, which begins with \"solid\", nor binary STL";
  CHECK(refused("x") == neither + ", which has at least 84 bytes");
  CHECK(refused(binary_stl("", 3)) == neither + ": for its 3 triangles it would have 234 bytes, but it has 184");
  CHECK(refused(binary_stl("solid", 4294967295)) ==
        neither + ": for its 4294967295 triangles it would have 214748364834 bytes, but it has 184");
  CHECK_THAT(refused("solid\nendsolid\n"), Catch::StartsWith("m.stl: has no faces"));
  CHECK(refused("solid\nvertex 0 0\n") == "m.stl: line 2: a vertex has the value '', which is not a number");
  CHECK(refused("solid\nvertex 0 0 0\nendloop\n") == "m.stl: line 3: a triangle has 1 vertices, must have 3");
  CHECK(refused("solid\nvertex 0 0 0\n") == "m.stl: line 2: ends within a triangle");
  CHECK(refused("solid\nedge 0 0 0\n") == "m.stl: line 2: begins with 'edge', which is no word of STL");
  CHECK(refused("SOLID\nVERTEX 0 0\n") == "m.stl: line 2: a vertex has the value '', which is not a number");
  CHECK(refused("Solid\nVertex 0 0 0 1\n") == "m.stl: line 2: a vertex has more than 3 numbers");
  // Bytes are missing at the end of a binary file that begins as an ASCII one.
  CHECK_THAT(refused(binary_stl("solid").substr(0, 180)),
             Catch::Contains("for its 2 triangles it would have 184 bytes, but it has 180"));
  const std::string corner = "vertex 1 0 0\n";
  CHECK(refused("solid\n" + corner + corner + corner + corner) == "m.stl: line 5: a triangle has a fourth vertex");
  const std::string nan = "vertex nan 0 0\n";
  CHECK(parse_stl("solid\n" + nan + nan + corner + "endloop\n", "m.stl").positions.size() == 3);
}

Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1.5f, 0, 0}, {0, 0.1f, 0}, {0, 0, -1e-20f}};
  mesh.colors = {{0, 1, 2}, {255, 254, 253}, {10, 13, 26}, {128, 0, 64}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

void check_same(const TriangleSoup& soup, const Mesh& mesh) {
  REQUIRE(soup.positions.size() == mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) CHECK(soup.positions[i] == glm::dvec3(mesh.positions[i]));
  CHECK(soup.colors == mesh.colors);
  CHECK(soup.faces == mesh.faces);
}

TEST_CASE("a mesh that was written as PLY reads back the same") {
  const TemporaryFolder folder;
  Mesh mesh = tetrahedron();
  write_ply(folder / "a.ply", mesh);
  check_same(read_triangle_soup(folder / "a.ply"), mesh);
  mesh.colors.clear();
  write_ply(folder / "a.ply", mesh);  // over the old one
  check_same(read_triangle_soup(folder / "a.ply"), mesh);
  CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("a written PLY is laid out as any reader expects") {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.positions = {{1, 2, 3}};
  mesh.colors = {{4, 5, 6}};
  mesh.faces = {{0, 0, 0}};
  write_ply(folder / "a.ply", mesh);
  const std::string body("\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40\4\5\6\3\0\0\0\0\0\0\0\0\0\0\0\0", 28);
  CHECK(bytes_of(folder / "a.ply") ==
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
        "property list uchar uint vertex_indices\nend_header\n" +
            body);
}

TEST_CASE("a mesh that cannot be written leaves nothing behind") {
  const TemporaryFolder folder;
  Mesh mesh = tetrahedron();
  CHECK_THROWS_WITH(write_ply(folder / "none/a.ply", mesh),
                    (folder / "none/a.ply").string() + ": cannot be written, its folder does not exist");
  mesh.faces[1].y = 4;
  CHECK_THROWS_MATCHES(write_ply(folder / "a.ply", mesh), std::invalid_argument,
                       Catch::Message("mesh.faces[1] refers to vertex 4; it must be below 4"));
  mesh.colors.pop_back();
  CHECK_THROWS_MATCHES(write_ply(folder / "a.ply", mesh), std::invalid_argument,
                       Catch::Message("mesh.colors has 3 entries; it must be empty or have one per position (4)"));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("the reader of a mesh file is picked by its ending, in any case") {
  const TemporaryFolder folder;
  CHECK(read_triangle_soup(folder.with_file("a.PlY", square(Encoding::Little).bytes())).positions == kSquare);
  CHECK(read_triangle_soup(folder.with_file("a.OBJ", "v 0 0 0\nf 1 1 1\n")).faces == FaceList{{0, 0, 0}});
  CHECK(read_triangle_soup(folder.with_file("a.Stl", kAsciiStl)).faces.size() == 2);
  const fs::path fbx = folder.with_file("a.fbx", "solid");
  CHECK_THROWS_WITH(read_triangle_soup(fbx),
                    fbx.string() + ": the ending '.fbx' is not .ply, .obj or .stl; convert the mesh to one of these");
  const fs::path missing = folder / "missing.ply";
  CHECK_THROWS_WITH(read_triangle_soup(missing), missing.string() + ": no such file");
  fs::create_directory(folder / "folder.obj");
  CHECK_THROWS_WITH(read_triangle_soup(folder / "folder.obj"), (folder / "folder.obj").string() + ": is not a file");
  const fs::path empty = folder.with_file("empty.ply", "");
  CHECK_THROWS_WITH(read_triangle_soup(empty), empty.string() + ": is empty");
}

TEST_CASE("the meshes of real scenes load whole") {
  struct Counts {
    const char* name;
    std::size_t vertices, faces, colors;
  };
  for (const Counts& expected : {Counts{"office", 411737, 781559, 411737}, Counts{"fox", 429956, 859557, 0},
                                 Counts{"sceaux", 159409, 318663, 0}}) {
    const std::optional<fs::path> scene = real_scene_or_skip(expected.name);
    if (!scene) return;
    const TriangleSoup soup = read_triangle_soup(*scene / "mesh.ply");
    CAPTURE(expected.name);
    CHECK(soup.positions.size() == expected.vertices);
    CHECK(soup.faces.size() == expected.faces);
    CHECK(soup.colors.size() == expected.colors);
  }
}

TEST_CASE("points of a PLY need no faces, and come with colours and normals where it has them") {
  const std::string xyz =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\n";
  const PointSoup plain = parse_ply_points(xyz + "end_header\n1 2 3\n4 5 nan\n", "m.ply");
  REQUIRE(plain.positions.size() == 2);
  CHECK(plain.positions[0] == glm::dvec3(1, 2, 3));
  CHECK(std::isnan(plain.positions[1].z));
  CHECK(plain.colors.empty());
  CHECK(plain.normals.empty());
  const PointSoup rich = parse_ply_points(
      xyz +
          "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
          "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
          "1 2 3 0 0 -1 10 20 30\n4 5 6 0 1 0 0 0 0\n3 0 1 7\n",
      "m.ply");  // its face is not looked at
  CHECK(rich.normals.at(0) == glm::vec3(0, 0, -1));
  CHECK(rich.colors.at(0) == glm::u8vec3(10, 20, 30));
  CHECK_THROWS_WITH(parse_ply_points("ply\nformat ascii 1.0\nend_header\n", "m.ply"), "m.ply: has no vertices");
  CHECK_THROWS_AS(parse_ply_points(xyz + "end_header\n1 2 3\n", "m.ply"), InputError);
}

TEST_CASE("a soup far from the origin is written to the last digit") {
  const TriangleSoup soup{{{4.5e6 + 1e-9, -5.4e6, 200}, {4.5e6, -5.4e6 + 0.125, 200}, {4.5e6, -5.4e6, 200.0625}},
                          {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}},
                          {{0, 1, 2}}};
  std::ostringstream file;
  write_ply(file, soup);
  const TriangleSoup read = ply(file.str());
  CHECK(read.positions == soup.positions);
  CHECK(read.colors == soup.colors);
  CHECK(read.faces == soup.faces);
  TriangleSoup wrong = soup;
  wrong.colors.pop_back();
  CHECK_THROWS_AS(write_ply(file, wrong), std::invalid_argument);
  wrong = soup;
  wrong.faces[0].z = 3;
  CHECK_THROWS_AS(write_ply(file, wrong), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
