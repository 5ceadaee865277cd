// The HDF5 of Debian and Ubuntu can open files on Amazon's S3, by libcurl and OpenSSL. Talik opens files on disks only: in programs
// that hold all their libraries these functions, which nobody calls, stand where the network would be.
#include <stddef.h>

int curl_global_init(long flags) { return (void)flags, 1; }
void curl_global_cleanup(void) {}
void* curl_easy_init(void) { return NULL; }
void curl_easy_cleanup(void* curl) { (void)curl; }
int curl_easy_perform(void* curl) { return (void)curl, 1; }
int curl_easy_setopt(void* curl, int option, ...) { return (void)curl, (void)option, 1; }
void* curl_slist_append(void* list, const char* text) { return (void)list, (void)text, NULL; }
void curl_slist_free_all(void* list) { (void)list; }
const void* EVP_sha256(void) { return NULL; }
unsigned char* SHA256(const unsigned char* data, size_t size, unsigned char* digest) { return (void)data, (void)size, (void)digest, NULL; }
unsigned char* HMAC(const void* method, const void* key, int key_size, const unsigned char* data, size_t size, unsigned char* digest, unsigned* digest_size) {
    return (void)method, (void)key, (void)key_size, (void)data, (void)size, (void)digest, (void)digest_size, NULL;
}
