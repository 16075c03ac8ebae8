#include "transport/uri.h"

#include "gicube/error.h"
#include "test.h"

namespace gicube {
namespace {

std::string error_of(std::string_view text) {
  return message_of<BadArgument>([&] { parse_uri(text); });
}

TEST(Uri, EmuStandsForABoardWithItsDefaults) {
  for (const char* text : {"emu:", "emu:?"}) {
    const Uri uri = parse_uri(text);
    EXPECT_EQ(uri.scheme, UriScheme::kEmu);
    EXPECT_THAT(uri.board_arguments, IsEmpty());
  }
}

TEST(Uri, EmuOptionsBecomeTheBoardsArgumentsInTheirOrder) {
  const Uri uri = parse_uri(
      "emu:?fidelity=cycle&bus=agp2x&threads=2&config=a%20b%26c.txt&set=asic.processors=8&set=dsp.clock_khz=1000");
  EXPECT_THAT(uri.board_arguments,
              ElementsAre("--set", "fidelity=cycle", "--set", "bus.model=agp2x", "--set", "threads=2", "--config",
                          "a b&c.txt", "--set", "asic.processors=8", "--set", "dsp.clock_khz=1000"));
  EXPECT_EQ(uri.threads, 2u);
}

TEST(Uri, ThePaceIsOneOfTwo) {
  EXPECT_THAT(parse_uri("emu:?pace=realtime").board_arguments, ElementsAre("--set", "pace=realtime"));
  EXPECT_EQ(error_of("emu:?pace=fast"), "URI option pace: expected one of as_fast_as_possible, realtime, got \"fast\"");
}

TEST(Uri, UnixTakesThePathWithItsPercentEscapes) {
  const Uri uri = parse_uri("unix:/run/a%3fb/board%25.sock");
  EXPECT_EQ(uri.scheme, UriScheme::kUnix);
  EXPECT_EQ(uri.path, "/run/a?b/board%.sock");
}

TEST(Uri, PciTakesTheAddressOfAFunction) {
  for (const char* text : {"pci:0000:00:1f.7", "pci:00:1F.7"}) {
    const Uri uri = parse_uri(text);
    EXPECT_EQ(uri.scheme, UriScheme::kPci);
    EXPECT_EQ(uri.path, "0000:00:1f.7");
    EXPECT_EQ(text_of(uri), "pci:0000:00:1f.7");
  }
  EXPECT_EQ(parse_uri("pci:12ab:cd:00.0").path, "12ab:cd:00.0");
  for (const char* text : {"pci:", "pci:4", "pci:00:20.0", "pci:00:04.8", "pci:00:04.0?", "pci:00:04",
                           "pci:0000:00:04.00", "pci:00:+4.0", "pci:00000:00:04.0", "pci:../00:04.0"}) {
    EXPECT_EQ(error_of(text),
              std::string("URI: expected pci:DOMAIN:BUS:SLOT.FUNCTION, as pci:0000:00:04.0 (lspci -D lists "
                          "addresses), got \"") +
                  text + "\"");
  }
}

TEST(Uri, TcpTakesHostAndPort) {
  const Uri name = parse_uri("tcp:localhost:7000");
  EXPECT_EQ(name.scheme, UriScheme::kTcp);
  EXPECT_EQ(name.host, "localhost");
  EXPECT_EQ(name.port, 7000);
  EXPECT_FALSE(name.is_secure);
  const Uri secure = parse_uri("tls:localhost:7000");
  EXPECT_TRUE(secure.is_secure);
  EXPECT_EQ(secure.scheme, UriScheme::kTcp);
  EXPECT_EQ(text_of(secure), "tls:localhost:7000");
  EXPECT_EQ(error_of("tls:host"), "URI: expected tls:HOST:PORT, got \"tls:host\"");
  const Uri six = parse_uri("tcp:[fe80::1]:65535");
  EXPECT_EQ(six.host, "fe80::1");
  EXPECT_EQ(six.port, 65535);
}

TEST(Uri, AnUnknownSchemeIsNamed) {
  EXPECT_THAT(error_of("usb:0"), HasSubstr("usb:0"));
  EXPECT_THAT(error_of("emu"), HasSubstr("emu:"));
  EXPECT_THAT(error_of(""), HasSubstr("URI"));
}

TEST(Uri, AnUnknownOptionOrValueIsNamedWithWhatIsAllowed) {
  EXPECT_THAT(error_of("emu:?speed=9"), HasSubstr("\"speed\""));
  EXPECT_THAT(error_of("emu:?fidelity=perfect"), HasSubstr("fidelity: expected one of functional, cycle"));
  EXPECT_THAT(error_of("emu:?bus=isa"), HasSubstr("pci33, agp1x, agp2x, agp4x"));
  EXPECT_THAT(error_of("emu:?threads=-1"), HasSubstr("threads"));
  EXPECT_THAT(error_of("emu:?threads=2x"), HasSubstr("2x"));
  EXPECT_THAT(error_of("emu:?threads=5000"), HasSubstr("1024"));
  EXPECT_THAT(error_of("emu:?config="), HasSubstr("config"));
  EXPECT_THAT(error_of("emu:?set=asic.processors"), HasSubstr("path.to.field=value"));
  EXPECT_THAT(error_of("emu:?fidelity"), HasSubstr("option=value"));
  EXPECT_THAT(error_of("emu:?bus=pci33&bus=agp1x"), HasSubstr("twice"));
  EXPECT_THAT(error_of("emu:0"), HasSubstr("emu:0"));
}

TEST(Uri, BrokenEscapesAreRefused) {
  for (const char* text : {"unix:/a%", "unix:/a%4", "unix:/a%zz", "unix:/a%00b", "emu:?config=%g1"}) {
    EXPECT_THAT(error_of(text), HasSubstr("%")) << text;
  }
}

TEST(Uri, PlacesThatAreNoneAreRefused) {
  for (const char* text :
       {"unix:", "unix:/a?bus=pci33", "tcp:", "tcp:host", "tcp::7000", "tcp:host:0", "tcp:host:65536",
        "tcp:host:7000?bus=pci33", "tcp:::1:7000", "tcp:[::1:7000", "tcp:[]:7000"}) {
    EXPECT_NE(error_of(text), "none") << text;
  }
}

TEST(Uri, AFaultPlanAndItsLogGoToTheBoard) {
  const Uri uri = parse_uri("emu:?faults=a%20plan&fault_log=log");
  EXPECT_EQ(uri.board_arguments, (std::vector<std::string>{"--faults", "a plan", "--fault-log", "log"}));
  EXPECT_THROW(parse_uri("emu:?faults="), BadArgument);
  EXPECT_THROW(parse_uri("emu:?faults=a&faults=b"), BadArgument);
}

TEST(Uri, EventsAndWindowsGoToTheBoard) {
  EXPECT_EQ(parse_uri("emu:?events=e&events_of=pixel=3:4&trace_window=5:9").board_arguments,
            (std::vector<std::string>{"--events", "e", "--events-of", "pixel=3:4", "--trace-window", "5:9"}));
  EXPECT_THROW(parse_uri("emu:?events_of="), BadArgument);
}

TEST(Uri, ATraceIsWrittenByTheBoard) {
  EXPECT_EQ(parse_uri("emu:?trace=a%20file").board_arguments, (std::vector<std::string>{"--trace", "a file"}));
  EXPECT_THROW(parse_uri("emu:?trace="), BadArgument);
}

TEST(Uri, ACaptureIsTheDriversOwnAffair) {
  const Uri saved = parse_uri("emu:?restore=warm");
  EXPECT_TRUE(saved.restores);
  EXPECT_EQ(saved.board_arguments, (std::vector<std::string>{"--restore", "warm"}));
  EXPECT_FALSE(parse_uri("emu:").restores);
  const Uri uri = parse_uri("emu:?capture=a%20session");
  EXPECT_EQ(uri.capture, "a session");
  EXPECT_TRUE(uri.board_arguments.empty());
  EXPECT_THROW(parse_uri("emu:?capture="), BadArgument);
}

TEST(Uri, ARefusalNamesFieldExpectationAndValueInThisOrder) {
  EXPECT_EQ(error_of("usb:0"),
            "URI: expected emu:, unix:PATH, tcp:HOST:PORT, tls:HOST:PORT or pci:ADDRESS, got \"usb:0\"");
  EXPECT_EQ(error_of("emu:0"), "URI: expected emu: or emu:?option=value, got \"emu:0\"");
  EXPECT_THAT(error_of("emu:?boards=2"),
              HasSubstr("(boards and buses are options of BoardGroup::open()), got \"boards\""));
  EXPECT_EQ(error_of("emu:?fidelity"), "URI option: expected option=value, got \"fidelity\"");
  EXPECT_EQ(error_of("emu:?bus=pci33&bus=agp1x"), "URI option bus: expected to be given once, got it twice");
  EXPECT_EQ(error_of("emu:?threads=1025"), "URI option threads: expected a number from 0 to 1024, got \"1025\"");
  EXPECT_EQ(error_of("emu:?threads=1024"), "none");
  EXPECT_EQ(error_of("emu:?config="), "URI option config: expected a file name, got \"\"");
  for (const char* set : {"a", "=1", "a.b="}) {
    EXPECT_EQ(error_of(std::string("emu:?set=") + set),
              std::string("URI option set: expected path.to.field=value, got \"") + set + '"');
  }
  EXPECT_EQ(error_of("unix:"), "URI: expected unix:PATH, got no path");
  EXPECT_EQ(
      error_of("unix:/a?b"),
      "URI: expected unix:PATH without options (they are for emu:; %3F stands for ? in a path), got \"unix:/a?b\"");
  EXPECT_EQ(error_of("unix:/a%4"), "URI path: expected two hexadecimal digits after each %, got \"/a%4\"");
  EXPECT_EQ(error_of("unix:/a%00"), "URI path: expected no %00, got \"/a%00\"");
  EXPECT_EQ(error_of(std::string_view("unix:/a\0b", 9)), "URI path: expected text without zero bytes, got one at 2");
  EXPECT_EQ(error_of("tcp:host"), "URI: expected tcp:HOST:PORT, got \"tcp:host\"");
  EXPECT_EQ(error_of("tcp:[]:7000"), "URI: expected tcp:[IPV6]:PORT, got \"tcp:[]:7000\"");
  EXPECT_EQ(error_of("tcp:host:0"),
            "URI: expected a port from 1 to 65535 in tcp:HOST:PORT, and no options, got \"tcp:host:0\"");
}

TEST(Uri, HoldsNoZeroByte) {
  EXPECT_THROW(parse_uri(std::string_view("emu:?config=a\0b", 15)), BadArgument);
  EXPECT_THROW(parse_uri(std::string_view("unix:/tmp/a\0b", 13)), BadArgument);
}

}  // namespace
}  // namespace gicube
