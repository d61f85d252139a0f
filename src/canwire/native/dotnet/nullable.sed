# Takes the marks of nullable references (T? and x!) out of C#, for compilers that do not know them: sed -E -f.
# Numbers and the like keep theirs, which every compiler knows.
s/\b(bool|byte|sbyte|char|decimal|double|float|int|uint|long|ulong|short|ushort|DateTime|TimeSpan|Guid)\?/\1\x01/g
s/([A-Za-z0-9_>]|\])\?(\[\])?( +[A-Za-z_0-9]+ *([;=,){(]|in |$))/\1\2\3/g
s/([A-Za-z0-9_>]|\])\?([],)>;])/\1\2/g
s/([A-Za-z0-9_)]|\])!([].;,)[( ]|$)/\1\2/g
s/\x01/?/g
