#!/usr/bin/env bash
# The main job, from nothing to pictures:  tools/demo.sh PROGRAM FOLDER   (./dev demo runs it)
set -euo pipefail
calot=$1
out=$2

# run WHAT ARG…: says what, shows the command, runs it and says how long it took.
run() {
  local what=$1 start=$(date +%s%N)
  shift
  printf '\n== %s\n   calot %s\n' "$what" "$*"
  "$calot" "$@" | sed 's/^/   /'
  awk -v ns=$(($(date +%s%N) - start)) 'BEGIN { printf "   %.1f s\n", ns / 1e9 }'
}

# The plane across the middle of the cystic duct, "px,py,pz,nx,ny,nz" in metres, from its centreline.
plane_across_duct() {
  awk '/"name": "cystic duct"/ { wanted = 1 } /"name": "common bile duct"/ { wanted = 0 }
    wanted && /^ *-?[0-9.]+(e-?[0-9]+)?,?$/ { gsub(/[ ,]/, ""); value[count++] = $0 }
    END {
      m = 3 * int(count / 6)
      for (i = 0; i < 3; ++i) plane = plane value[m + i] / 1000 ","
      for (i = 0; i < 3; ++i) plane = plane value[m - 3 + i] - value[m + i] (i < 2 ? "," : "")
      print plane
    }' "$1"
}

# The number of the vertex that lies farthest along a direction: the tip of the gallbladder, its fundus.
vertex_farthest_along() {
  awk -v x="$2" -v y="$3" -v z="$4" '/^\$Nodes/ { inside = 1; getline; next } /^\$EndNodes/ { exit }
    inside { d = x * $2 + y * $3 + z * $4; if (best == "" || d > best) { best = d; number = count } ++count }
    END { print number }' "$1"
}

mkdir -p "$out"
run "A synthetic patient: CT, labels and centrelines, made from published measurements" phantom -o "$out/scan" --seed 1
run "From CT to a patient that can be operated on" patient "$out/scan/ct.nii.gz" "$out/scan/labels.nii.gz" \
  --ducts "$out/scan/ducts.mrk.json" -o "$out/patient"

run "The biliary tree alone, as in the paper" phantom --tree -o "$out/tree" --seed 1
run "Its mesh, as large as the paper's" mesh "$out/tree/labels.nii.gz" -o "$out/organ" --vertices 2442 --refine "cystic duct:1.2"

plane=$(plane_across_duct "$out/tree/ducts.mrk.json")
fundus=$(vertex_farthest_along "$out/organ/mesh.msh" 0.40 0.62 -0.68)
cut=(--plane "$plane" --region "cystic duct" --clean)

run "Its compliance: how every vertex answers to a force on any other" precompute "$out/organ/model.toml" -o "$out/C.h5"
run "The cut, the compliance kept exact" cut "$out/organ/model.toml" "$out/C.h5" "${cut[@]}" -o "$out/cut"
run "The fundus is lifted with 0.3 N: recomputed, by the paper's update, and exactly" \
  compare "$out/organ/model.toml" "${cut[@]}" --force "$fundus,0,0,0.3" -o "$out/comparison"
run "The paper's figure 4, three ways of probing" bench figure4 -o "$out/figures"
run "The paper's figure 5, and its table of times" bench figure5 -o "$out/figures"

compared() { awk -F , -v method="$1" -v column="$2" '$1 == method { printf "%.3g", $column }' "$out/comparison/compare.csv"; }
cat >"$out/README.txt" <<TEXT
What one sees

patient/preview.png        A synthetic patient from CT to an operable abdomen: organs, ports, clips, Calot's triangle, CT slices.
                           patient/patient.toml is meant to be read and changed.
organ/preview.png          The synthetic patient's gallbladder, cystic duct and common bile duct as a tetrahedral mesh.
comparison/compare.png     The organ after its cystic duct was cut and the fundus lifted with 0.3 N; displacements are
                           magnified as the caption says. Blue is the truth: everything computed anew for the cut organ.
                           Left, the update of the paper of 2013 lies over it, up to $(compared paper 3) mm off, which is
                           $(compared paper 6) % of the largest displacement; right, Calot's exact update, up to
                           $(compared exact 3) mm off.
comparison/compare.csv     The same in numbers, with the time until each could be used.
figures/figure4_*.png      The paper's figure 4, probed far from the cut, at its face, and on the part that only the duct
                           held. figure4.csv has the numbers beside the paper's own 0.1246 / 0.0198 / 0.0192 mm.
figures/figure5.png, .csv  The paper's figure 5: the time to have a compliance again after a cut, by size of the mesh.
cut/                       The cut mesh, its model and its compliance (also readable by h5py); summary.json says what
                           was removed, which parts there are and how long each step took.
C.h5                       The compliance before the cut.
TEXT
printf '\nDone. %s\n' "See $out/README.txt and the pictures it names."
