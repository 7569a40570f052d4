// pith-tetgen: fills one closed surface, or all between facets inside one, with tetrahedra and ends.
//
// TetGen (Si, "TetGen, a Delaunay-Based Quality Tetrahedral Mesh Generator", ACM TOMS 41(2), 2015) ends the process on
// every error, is not thread-safe and is under the AGPL; so it lives here, behind one socket on descriptor 0 (see
// tetgen_protocol.h). Whatever happens to this program, the one that started it sees a complete reply or none.
#include "../src/shape/tetgen_protocol.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <signal.h>
#include <unistd.h>

#include <tetgen.h>

namespace {

const int channel = 0;

bool read_all(void *data, size_t size)
{
    char *at = static_cast<char *>(data);
    while (size > 0) {
        const ssize_t got = read(channel, at, size);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got;
        size -= static_cast<size_t>(got);
    }
    return true;
}

bool write_all(const void *data, size_t size)
{
    const char *at = static_cast<const char *>(data);
    while (size > 0) {
        const ssize_t put = write(channel, at, size);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return false;
        at += put;
        size -= static_cast<size_t>(put);
    }
    return true;
}

// Ends at once: TetGen's destructors have nothing to add, and may crash after an error.
[[noreturn]] void answer(uint32_t outcome, uint32_t crossing_count)
{
    const pith_tetgen_reply reply = { PITH_TETGEN_MAGIC, outcome, crossing_count, 0, 0 };
    _exit(write_all(&reply, sizeof reply) ? 0 : 1);
}

void limit(int resource, double most)
{
    if (!(most > 0.0 && most < 1e15)) return;
    const rlim_t value = static_cast<rlim_t>(most);
    const rlimit both = { value, value };
    setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

// Nothing TetGen prints may reach the channel or the terminal, no core file, no file of the parent kept open, and no
// life after the parent's.
void shut_off()
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGPIPE, SIG_IGN);
    const rlimit none = { 0, 0 };
    setrlimit(RLIMIT_CORE, &none);
    const int nothing = open("/dev/null", O_WRONLY);
    if (nothing >= 0) {
        dup2(nothing, 1);
        dup2(nothing, 2);
    }
    close_range(3, ~0U, 0);
}

struct job {
    pith_tetgen_request request;
    std::vector<double> points, interior, sizes;
    std::vector<uint32_t> triangles;
};

bool read_job(job *j)
{
    pith_tetgen_request &r = j->request;
    if (!read_all(&r, sizeof r) || r.magic != PITH_TETGEN_MAGIC) return false;
    limit(RLIMIT_AS, r.memory_limit * 1048576.0);
    limit(RLIMIT_CPU, std::ceil(r.time_limit) + 1.0);
    if (r.point_count > PITH_TETGEN_MOST || r.interior_count > PITH_TETGEN_MOST || r.triangle_count > PITH_TETGEN_MOST)
        return false;
    j->points.resize(3 * size_t(r.point_count));
    j->interior.resize(3 * size_t(r.interior_count));
    j->triangles.resize(3 * size_t(r.triangle_count));
    j->sizes.resize(r.conform ? size_t(r.point_count) : 0);
    if (!read_all(j->points.data(), j->points.size() * sizeof(double)) ||
        !read_all(j->interior.data(), j->interior.size() * sizeof(double)) ||
        !read_all(j->triangles.data(), j->triangles.size() * sizeof(uint32_t)) ||
        !read_all(j->sizes.data(), j->sizes.size() * sizeof(double)))
        return false;
    for (uint32_t v : j->triangles)
        if (v >= r.point_count) return false;
    return true;
}

// tetgenio frees what it holds with delete[], so everything in it is made with new[].
void fill_input(const job &j, tetgenio *in)
{
    in->firstnumber = 0;
    in->numberofpoints = static_cast<int>(j.request.point_count);
    in->pointlist = new double[j.points.size()];
    for (size_t i = 0; i < j.points.size(); ++i) in->pointlist[i] = j.points[i];
    in->numberoffacets = static_cast<int>(j.request.triangle_count);
    in->facetlist = new tetgenio::facet[j.request.triangle_count];
    for (uint32_t t = 0; t < j.request.triangle_count; ++t) {
        tetgenio::facet &f = in->facetlist[t];
        tetgenio::init(&f);
        f.numberofpolygons = 1;
        f.polygonlist = new tetgenio::polygon[1];
        tetgenio::init(&f.polygonlist[0]);
        f.polygonlist[0].numberofvertices = 3;
        f.polygonlist[0].vertexlist = new int[3];
        for (int k = 0; k < 3; ++k) f.polygonlist[0].vertexlist[k] = static_cast<int>(j.triangles[3 * size_t(t) + k]);
    }
}

// TetGen's own test for crossing triangles: meshing crashes exactly where it finds some.
void refuse_crossings(const job &j)
{
    tetgenio in, out;
    char switches[] = "dQ";
    fill_input(j, &in);
    tetrahedralize(switches, &in, &out);
    if (out.numberoftrifaces > 0) answer(PITH_TETGEN_CROSSES, static_cast<uint32_t>(out.numberoftrifaces));
}

// The most triangles that meet in one vertex.
uint32_t most_valence(const job &j)
{
    std::vector<uint32_t> valence(j.request.point_count, 0);
    uint32_t most = 0;
    for (uint32_t v : j.triangles)
        if (++valence[v] > most) most = valence[v];
    return most;
}

// How deep flips that mend slivers are tried. Their number grows with the edges of a vertex to the power of the depth:
// at the pole of a swept surface of 120 triangles depth 9 does not end within minutes. Depth 5 takes a second there and
// leaves 7 % of the tetrahedra with angles below 10 degrees; elsewhere 9 leaves fewer.
int flip_depth(const job &j) { return most_valence(j) > 48 ? 5 : 9; }

// q: radius / edge bound and 14 degrees of dihedral angle; Y: the surface stays as it is; O9/7: most thorough
// optimisation of slivers (without it 82 % of a sphere's tetrahedra have angles below 5 degrees); Q: quiet.
void mesh(const job &j, tetgenio *out)
{
    tetgenio in, extra;
    fill_input(j, &in);
    if (j.request.interior_count > 0) {
        extra.firstnumber = 0;
        extra.numberofpoints = static_cast<int>(j.request.interior_count);
        extra.pointlist = new double[j.interior.size()];
        for (size_t i = 0; i < j.interior.size(); ++i) extra.pointlist[i] = j.interior[i];
    }
    char size[64] = "", switches[160];
    if (j.request.volume_bound > 0.0) snprintf(size, sizeof size, "a%.12e", j.request.volume_bound);
    snprintf(switches, sizeof switches, "pq%.6f/14YO%d/7Q%s%s", j.request.radius_edge, flip_depth(j), size,
             j.request.interior_count > 0 ? "i" : "");
    tetrahedralize(switches, &in, out, j.request.interior_count > 0 ? &extra : nullptr);
}

// q: radius / edge bound and 10 degrees of dihedral angle; M: every triangle stays a facet of its own, so that each piece
// knows the one it comes from; m: sizes at the points, interpolated in between. Without Y facets may be cut: where they
// are large, the tetrahedra on both sides could else not be small.
void mesh_conforming(const job &j, tetgenio *out)
{
    tetgenio in;
    fill_input(j, &in);
    in.facetmarkerlist = new int[j.request.triangle_count];
    for (uint32_t t = 0; t < j.request.triangle_count; ++t) in.facetmarkerlist[t] = static_cast<int>(t) + 1;
    in.numberofpointmtrs = 1;
    in.pointmtrlist = new double[j.sizes.size()];
    for (size_t i = 0; i < j.sizes.size(); ++i) in.pointmtrlist[i] = j.sizes[i];
    char switches[80];
    snprintf(switches, sizeof switches, "pq%.6f/10MmQ", j.request.radius_edge);
    tetrahedralize(switches, &in, out);
}

bool write_faces(const tetgenio &out)
{
    const uint32_t count = out.trifacelist && out.trifacemarkerlist ? static_cast<uint32_t>(out.numberoftrifaces) : 0;
    std::vector<uint32_t> records(4 * size_t(count));
    for (size_t f = 0; f < count; ++f) {
        for (size_t k = 0; k < 3; ++k) records[4 * f + k] = static_cast<uint32_t>(out.trifacelist[3 * f + k]);
        records[4 * f + 3] = static_cast<uint32_t>(out.trifacemarkerlist[f] - 1);
    }
    return write_all(&count, sizeof count) && write_all(records.data(), records.size() * sizeof(uint32_t));
}

} // namespace

int main()
{
    shut_off();
    job j;
    if (!read_job(&j)) answer(PITH_TETGEN_BAD_REQUEST, 0);
    if (j.request.check_intersections) refuse_crossings(j);
    tetgenio *out = new tetgenio; // never freed, see answer()
    if (j.request.conform) mesh_conforming(j, out);
    else mesh(j, out);
    if (out->numberoftetrahedra <= 0 || out->numberofcorners != 4) answer(PITH_TETGEN_EMPTY, 0);

    const pith_tetgen_reply reply = { PITH_TETGEN_MAGIC, PITH_TETGEN_DONE, 0,
                                      static_cast<uint32_t>(out->numberofpoints),
                                      static_cast<uint32_t>(out->numberoftetrahedra) };
    const bool sent = write_all(&reply, sizeof reply) &&
                      write_all(out->pointlist, 3 * size_t(reply.point_count) * sizeof(double)) &&
                      write_all(out->tetrahedronlist, 4 * size_t(reply.tet_count) * sizeof(int)) &&
                      (!j.request.conform || write_faces(*out));
    _exit(sent ? 0 : 1);
}
