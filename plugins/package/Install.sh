# Install/uninstall the package for the traditional make.
# mode = 0/1/2 for uninstall/install/update

mode=$1

LC_ALL=C
export LC_ALL

for file in *.cpp *.h; do
  if (test $mode = 0) then
    rm -f ../$file
  elif (! cmp -s $file ../$file) then
    cp $file ..
    if (test $mode = 2) then
      echo "  updating src/$file"
    fi
  fi
done

# Flags of the files of this package alone. Without contraction the forces on both spheres of a pair are rounded identically;
# without errno and traps the square roots of a batch are vectorized.

if (test $mode != 2 && test -e ../Makefile.package) then
  sed -i -e '/^granwave_flags/d' -e 's/[^ \t]*granwave_flags[^ \t]* //' ../Makefile.package
fi

if (test $mode = 1 && test -e ../Makefile.package) then
  sed -i -e 's|^PKG_INC =[ \t]*|&$(granwave_flags) |' ../Makefile.package
  cat >> ../Makefile.package <<'END'
granwave_flags = $(if $(wildcard ../GRANWAVE/$(notdir $<)),-ffp-contract=off -fno-math-errno -fno-trapping-math)
END
fi
