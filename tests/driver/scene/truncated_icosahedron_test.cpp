#include "scene/buckyball.h"

#include "test.h"

namespace gicube::scene {
namespace {

TEST(TruncatedIcosahedron, HasSixtyAtomsAtRadiusOne) {
  const Molecule molecule = truncated_icosahedron();
  ASSERT_EQ(molecule.atoms.size(), 60u);
  for (const Vec3& atom : molecule.atoms) EXPECT_NEAR(length(atom), 1, 1e-12);
}

TEST(TruncatedIcosahedron, HasNinetyBondsOfTheClosedFormLength) {
  const Molecule molecule = truncated_icosahedron();
  ASSERT_EQ(molecule.bonds.size(), 90u);
  const double edge = 4 / std::sqrt(58 + 18 * std::sqrt(5.0));  // of circumradius 1
  for (const auto& [from, to] : molecule.bonds) {
    const Vec3 bond = molecule.atoms[static_cast<std::size_t>(to)] - molecule.atoms[static_cast<std::size_t>(from)];
    EXPECT_NEAR(length(bond), edge, 1e-12);
  }
}

TEST(TruncatedIcosahedron, GivesEveryAtomThreeBonds) {
  const Molecule molecule = truncated_icosahedron();
  std::vector<int> bonds(molecule.atoms.size());
  for (const auto& [from, to] : molecule.bonds) {
    ++bonds[static_cast<std::size_t>(from)];
    ++bonds[static_cast<std::size_t>(to)];
  }
  for (const int count : bonds) EXPECT_EQ(count, 3);
}

TEST(TruncatedIcosahedron, TurnsAPentagonUpwards) {
  double top = -1;
  const Molecule molecule = truncated_icosahedron();
  for (const Vec3& atom : molecule.atoms) top = std::max(top, atom.z);
  int highest = 0;
  for (const Vec3& atom : molecule.atoms) highest += std::abs(atom.z - top) < 1e-9 ? 1 : 0;
  EXPECT_EQ(highest, 5);
}

}  // namespace
}  // namespace gicube::scene
