// The native libraries, found and loaded.
using System;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;

namespace Canwire.Native
{
    /// <summary>
    /// Loads libvciapi, and libcanwire with it, from where canwire had them when this assembly was compiled (its metadata
    /// "CanwireLibraries"), or from beside this assembly. Loaded, they are found by their names alone; where they are in
    /// neither place the system looks (LD_LIBRARY_PATH).
    /// </summary>
    internal static class Loading
    {
        internal const string Vci = "libvciapi.so";
        private const int Now = 2; // RTLD_NOW

        internal static void Load()
        {
            Assembly own = typeof(Loading).Assembly;
            string built = own.GetCustomAttributes<AssemblyMetadataAttribute>()
                .Where(one => one.Key == "CanwireLibraries").Select(one => one.Value).FirstOrDefault();
            foreach (string directory in new[] { built, Path.GetDirectoryName(own.Location) })
            {
                string path = Path.Combine(directory ?? "", Vci);
                if (File.Exists(path) && Open(path) != IntPtr.Zero)
                    return;
            }
        }

        private static IntPtr Open(string path)
        {
            try
            {
                return dlopen(path, Now);
            }
            catch (DllNotFoundException) // C libraries without a libdl
            {
                return dlopen_of_libc(path, Now);
            }
        }

        [DllImport("libdl.so.2")]
        private static extern IntPtr dlopen([MarshalAs(UnmanagedType.LPStr)] string path, int how);

        [DllImport("libc", EntryPoint = "dlopen")]
        private static extern IntPtr dlopen_of_libc([MarshalAs(UnmanagedType.LPStr)] string path, int how);
    }
}
