# Completion of tetfusion's arguments in bash, by what its --help says.
_tetfusion() {
  local program=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local command=${COMP_WORDS[1]} help values
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    help=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
    COMPREPLY=($(compgen -W "$help --help --version" -- "$word"))
    return
  fi
  help=$("$program" "$command" --help 2>/dev/null) || return
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(grep -oE -- '^ +-[^ ]+' <<<"$help" | tr ', ' '\n\n')" -- "$word"))
    return
  fi
  # --progress TEXT:{auto,always,never}, or KIND TEXT:{bcc,five,kuhn} behind the command
  if ((COMP_CWORD == 2)); then before='[A-Z]+'; elif [[ $before != -* ]]; then return; fi
  values=$(sed -nE "s/^ +([^ ]*,)?${before} [A-Z]+:\{([^}]*)\}.*/\2/p" <<<"$help" 2>/dev/null | tr ',' '\n')
  [[ -n $values ]] && COMPREPLY=($(compgen -W "$values" -- "$word"))
}
complete -o default -F _tetfusion tetfusion
