// A driver of a CUDA older than any that this program can be built with: all that the CUDA runtime asks before it gives up.
int cuInit(unsigned flags) { return (void)flags, 0; }
int cuDriverGetVersion(int* version) { return *version = 11040, 0; }
int cuDeviceGetCount(int* count) { return *count = 1, 0; }
