// VciServer: where everything starts. Source: VCI V3 .NET manual 2.1; the contract of Ixxat.Vci4.
using System;
using System.Runtime.CompilerServices;
using System.Text;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3
{
    /// <summary>The server: GetDeviceManager() is the way in.</summary>
    public static class VciServer
    {
        static VciServer()
        {
            Loading.Load();
        }

        /// <summary>A new manager, to be disposed of.</summary>
        public static IVciDeviceManager GetDeviceManager()
        {
            return Entry.Manager();
        }

        public static Version Version
        {
            get { return Entry.Version(); }
        }

        /// <summary>Name, number and meaning of a result code.</summary>
        public static string GetErrorMsg(int errorCode)
        {
            return Entry.ErrorText(errorCode);
        }
    }
#else
namespace Ixxat.Vci4
{
    using Bal.Can;
    using Bal.Lin;

    /// <summary>The server: Instance() is the way in.</summary>
    public class VciServer
    {
        private static readonly Lazy<IVciServer> instance = new Lazy<IVciServer>(Start);

        public static IVciServer Instance()
        {
            return instance.Value;
        }

        /// <summary>The same; a path means nothing here.</summary>
        public static IVciServer Instance(string assemblyloadpath)
        {
            return Instance();
        }

        private static IVciServer Start()
        {
            Loading.Load();
            return new Server();
        }

        private sealed class Server : IVciServer
        {
            public Version Version
            {
                get { return Entry.Version(); }
            }

            public IVciDeviceManager DeviceManager
            {
                get { return Entry.Manager(); }
            }

            public IMessageFactory MsgFactory
            {
                get { return new Factory(); }
            }

            public string GetErrorMsg(int errorCode)
            {
                return Entry.ErrorText(errorCode);
            }
        }

        private sealed class Factory : IMessageFactory
        {
            public object CreateMsg(Type msgtyp)
            {
                if (msgtyp == typeof(ICanMessage))
                    return new CanMessage();
                if (msgtyp == typeof(ICanMessage2))
                    return new CanMessage2();
                if (msgtyp == typeof(ILinMessage))
                    return new LinMessage();
                throw new ArgumentException("messages are ICanMessage, ICanMessage2 and ILinMessage, not " + msgtyp, "msgtyp");
            }
        }
    }
#endif

    /// <summary>
    /// What both versions of the server ask the library. Mono looks a library up when it compiles the method that calls
    /// into it, so these methods are no part of those that load it first.
    /// </summary>
    internal static class Entry
    {
        [MethodImpl(MethodImplOptions.NoInlining)]
        internal static IVciDeviceManager Manager()
        {
            Disposable.Check(Library.VciInitialize());
            return new VciDeviceManager();
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        internal static Version Version()
        {
            var info = new VciVersionInfo();
            Disposable.Check(Library.VciGetVersion(ref info));
            return new Version((int)info.Major, (int)info.Minor, (int)info.Release, (int)info.Build);
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        internal static string ErrorText(int code)
        {
            var text = new byte[256];
            if (Library.VciFormatErrorA(code, text, (uint)text.Length) != Results.Ok)
                return string.Format("VCI's result 0x{0:X8}", code);
            return Encoding.ASCII.GetString(text, 0, Math.Max(0, Array.IndexOf(text, (byte)0)));
        }
    }
}
