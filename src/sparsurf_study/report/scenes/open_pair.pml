# Both partners in the colours of their propensity (dark: good match). Open it from this folder: pymol open.pml
load partner_1.pdb, partner_1
load partner_2.pdb, partner_2
hide everything
show cartoon
show surface
spectrum b, 0x440154 0x31688E 0x35B779 0xFDE725, partner_1 or partner_2, %LOW%, %HIGH%
bg_color white
orient
