"""Restart files: damaged ones end in an error, and those of formats without a checksum are read."""

from __future__ import annotations

import base64
import struct
import zlib

import numpy as np
import pytest

from tests.helpers.rubbing import BRASS, MU, R, rubbing, state
from tests.helpers.two_spheres import value

WALL = f"fix wall all wall/gran/hysteretic zplane {-R:.17g} NULL hertz 115e9 0.3 support 1e-3 1e6 0"
PUSH = "fix push all gran/load z force half-sine 10 1e-3"
ATOM_STATE = struct.pack("<d", 0.6180339887498949)
OLD = (  # restart file of format 6: zlib, base 85
    "c-r$x%*`zbRtQQhE=epZ31MJlU|?WofB+sKHZoH1D$P+aGB7d)%dr5l0hDHf(jfI5NbKTF238<-BNAc^8&sGbh#8?unW1bL=7d_w1*N%>oB#s6P?"
    "`_PJZ#tyDqk(K&i!H4l>JcJ9zTDHJwMca#RVCuMX6w`1du{P5b8`J1_Tg>(jrh=6iH4DN{d5j2_!j5C@lr0rIF-hptLNMmV?srP`99Y15PWT%G;y"
    "TOY9Yq>`+2tD<iQzp|lE;zp(*T0`f*cY}I4%sISu1&KMeQCQ#ZGs@DvNUjP~ANct?Gv?Y?56;z)Mly3{A?Vz+hly-!w^M>-Bkj!vKV!I%*U6I)CN"
    "XgX=h;KbR_N7Ht&;CCUz*2o;P7VWzuMSNc=|zco`WcnQCBOtzl9>!nJ|8n4cWnLf1?s#H_UK_V;g-dxdwVpT8Q~&eHTyb_SveVl!DSHtfL6)@M+P"
    "FnteGJ2(;h;<w7<T%z?SPevx658lXkn<PJ4*CX%62sV)_q#WpV(giC?}BX<+cqz7VK-@drzX9dfO&19$X6&G~AN<Q^>Ghds>wu(+0K@ix#C(RK!f"
    "5d$<nK<VB+$k8v}BQiL|HOMu@(>dP5GdRRQC=x7(7KZv6nZ+gfMU@O*Ksg<#O(661LGc5#y20OJjel9lH7#wp+e&uZZDLz8)eaV}=rjWp2Plg$WG"
    "~G-J~Q++TwjWSi)G#<XqZ%$*xO70;67nh1edpa?R`B}E#v@-*Bjg&0$%Eyzd!cazQa`L)Bz_QXINM;q9~MbKurf9?9-O*vX`F~Vt+#X;oW&^hW3-"
    "{w{pEaamEfJ?qZKC-S}RzxfJ=Wz=473wfwPlU+iFEez4&ZU;Dm)c4f`HU%o1Cv15X&hxrHHeuf!=Teie=+Lv6N&JfP4YY$83E0^m`OA*zD%d1Nt?"
    "Gu>w#lGfO*6lO<BphJ&G5%w{t~{s9f%g`N?<H?8`|if)_PuO@@bH;`H`Mj@>CgM0+-U4!VGFl&t!g&ilm*KV6oQ5@hZ$!ZZiSuv4L5J%^tBZi5?b"
    "t;2*ms672G`+!;Ztl^-9N-C68G758#UT{>61Ke7*;u#d{Du-p}n;3pZ*~ffX$dOa$WHY;oq^&GS<1t<P2X2kIExC+N3!X`j1e2N4f}+3SGrWwtqI"
    "o5Ozr<NeUH-yxe2@xH<8+nwvX5%JDAF!2s^Zv!;m?WrB_%!K?E!^Rt8C~99-Fyl%1J#DzZ;#+(4c%Ep(<&XKMFOII?Z-1lG<@`#`NANQ1YTCMI*}"
    "^j%t|+Gp2OSi(FWqvWY+8#jJRW}L%sRQIuFt;Yzq!#Hqd>cLMH?3tew{$2^z85O{_@@ZeDlxmg9+`Oy18gc#1wmG0_pkYcZubXwk+BY6W(<={FLi"
    "4L7eG%gH2Z1@d`}`T;-Tk!Oz1RzAD1YF=hhknRS7Lwa4NR``MfK_Dt4gu-CmG!j*UVj2%QAcR5CEdS)7!c!%Zp257wRr*^#iptZIEzoLy{"
)


def resume(lmp, path, *fixes: str) -> None:
    """Read a restart file and run no step."""
    lmp.commands_string(
        f"newton off\natom_modify map yes\ncomm_modify vel yes\nread_restart {path}\n"
        + "\n".join([*fixes, "fix motion all nve/sphere", "timestep 1e-8"])
        + "\ncompute en all gran/hysteretic/energy\nthermo_style custom step c_en[*]\nrun 0 post no"
    )


def ours(data: bytes) -> list[int]:
    """Places of our own bytes in a restart file: settings and laws, states of fixes, states with atoms."""
    places = []
    at = data.index(b"gran/hysteretic\0") + len(b"gran/hysteretic\0")
    places += range(at, at + 4 + 5 * 8 + 4 + 27 * 8)
    for style in (b"wall/gran/hysteretic\0", b"gran/load\0"):
        at = data.index(style) + len(style)
        (size,) = struct.unpack("<i", data[at : at + 4])
        places += range(at + 4, at + 4 + size)
    at = data.find(ATOM_STATE)
    while at >= 0:
        size = int(struct.unpack("<d", data[at - 8 : at])[0])
        places += range(at - 8, at - 8 + 8 * size)
        at = data.find(ATOM_STATE, at + 1)
    return places


def test_a_damaged_byte_is_an_error(lammps, tmp_path):
    """Any byte of settings, laws, contacts, forgotten contacts, walls and loads, and no signal and no other result."""
    lmp = lammps()
    places = [(0, 0, 0), (0, 0, 2 * R), (0, 0, 4 * R)]
    text = rubbing(
        places, f"{BRASS} friction {MU} loss time 1e-8", velocities=[(1, 0, 1), (0, 0, 0), (0, 0, -1)], gap=2e-5
    )
    lmp.commands_string(f"{text}{WALL}\n{PUSH}\nrun 9000 post no\nwrite_restart {tmp_path}/good.restart")
    data = (tmp_path / "good.restart").read_bytes()
    chosen = ours(data)
    assert len(chosen) > 1500
    resume(lammps(), tmp_path / "good.restart", WALL, PUSH)
    rng = np.random.default_rng(5)
    for at in rng.choice(chosen, 80, replace=False):
        damaged = bytearray(data)
        damaged[at] ^= 1 << rng.integers(8)
        (tmp_path / "bad.restart").write_bytes(damaged)
        lmp = lammps()
        with pytest.raises(Exception, match=r"damaged|format|give it again|law number"):
            resume(lmp, tmp_path / "bad.restart", WALL, PUSH)
        lmp.close()


def test_contacts_that_are_missing_are_an_error(lammps, tmp_path):
    """The name of the fix that holds them is damaged: LAMMPS alone would go on without them."""
    lmp = lammps()
    lmp.commands_string(rubbing([(0, 0, 0), (0, 0, 2 * R)], velocities=[(0, 0, 1), (0, 0, 0)]) + "run 300 post no")
    lmp.command(f"write_restart {tmp_path}/a.restart")
    data = (tmp_path / "a.restart").read_bytes()
    (tmp_path / "a.restart").write_bytes(data.replace(b"GRAN_HYSTERETIC_HISTORY", b"GRAN_HYSTERETIC_HISTORx"))
    with pytest.raises(Exception, match="damaged: it holds no contacts"):
        resume(lammps(), tmp_path / "a.restart")


def test_files_without_checksums_are_read(lammps, tmp_path):
    """Format 6 with live and forgotten contacts, friction and loss: the run goes on as in the version that wrote it."""
    (tmp_path / "old.restart").write_bytes(zlib.decompress(base64.b85decode(OLD)))
    lmp = lammps()
    if lmp.version() < 20250722:
        pytest.skip("LAMMPS reads no restart file of a later LAMMPS")
    resume(lmp, tmp_path / "old.restart")
    totals = "0.05568798092946797 4 0 0 1540.8553721666588 4.993110249523872e-05 0.0003122821937953412 0.00014001305375356478"
    assert [value(lmp, f"c_en[{k}]") for k in range(1, 9)] == pytest.approx(
        [float(one) for one in totals.split()], rel=1e-12
    )
    lmp.command("run 4000 post no")
    assert value(lmp, "c_en[1]") == pytest.approx(0.11387576775004576, rel=1e-12)
    assert value(lmp, "vz[1]") == pytest.approx(-4.709439811399739, rel=1e-12)
    assert state(lmp, "omega")["omega"][0, 1] == pytest.approx(-93.39220502683045, rel=1e-12)
