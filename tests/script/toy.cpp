// The source that the test of script/mutate seeds faults into.
constexpr int kLimit = 20;

constexpr int twice(int a) { return 2 * a; }

int larger(int a, int b) {
  int out = b;
  if (a > b) out = a;
  return out;
}

int capped(int a, int b) {
  const int sum = twice(a) + b;
  return larger(-kLimit, sum > kLimit ? kLimit : sum);
}
