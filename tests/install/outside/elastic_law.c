/* elastic-law EXCHANGE: Hooke's law in C, as the farm of any driver. */
#include <exchange/c_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double lame = 2e7, shear = 1e7; /* Pa */

struct state { size_t rves; double* stress; };

static int configure(void* user, const talik_setup* setup, double* initial) {
    struct state* s = user;
    size_t i;
    s->rves = setup->rves;
    s->stress = malloc(3 * setup->rves * sizeof(double));
    memcpy(s->stress, setup->initial_stress, 3 * setup->rves * sizeof(double));
    memcpy(initial, s->stress, 3 * setup->rves * sizeof(double));
    for (i = 0; i < setup->rves; ++i) initial[3 * setup->rves + i] = lame + 2 * shear;
    return 0;
}

static int answer(void* user, const talik_batch* b) {
    struct state* s = user;
    size_t i, n = b->rows;
    for (i = 0; i < n; ++i) {
        const double xx = b->request[i], yy = b->request[3 * n + i], xy = b->request[n + i] + b->request[2 * n + i];
        double* stress = s->stress;
        const size_t rve = b->ids[i];
        if (xx > 0.5) {
            talik_set_error("stretched by more than a half in one step");
            return 1;
        }
        stress[rve] += lame * (xx + yy) + 2 * shear * xx;
        stress[s->rves + rve] += lame * (xx + yy) + 2 * shear * yy;
        stress[2 * s->rves + rve] += shear * xy;
        b->answer[i] = stress[rve];
        b->answer[n + i] = stress[s->rves + rve];
        b->answer[2 * n + i] = stress[2 * s->rves + rve];
        b->answer[3 * n + i] = lame + 2 * shear;
    }
    return 0;
}

int main(int argc, char** argv) {
    const talik_column request[] = {{"displacement_gradient_increment", 4, "1", NULL}};
    const talik_column answers[] = {{"stress", 3, "Pa", NULL}, {"stiffness", 1, "Pa", NULL}};
    struct state state = {0, NULL};
    talik_law law;
    int code;
    if (argc != 2) return 2;
    memset(&law, 0, sizeof law);
    law.size = sizeof law;
    law.name = "Hooke in C";
    law.request = request, law.request_columns = 1;
    law.answer = answers, law.answer_columns = 2;
    law.configure = configure, law.answer_batch = answer;
    code = talik_serve(argv[1], &law, &state, 30);
    if (code != 0) fprintf(stderr, "error: %s\n", talik_last_error());
    free(state.stress);
    return code;
}
